// Merging exposures: unbiased from the floor to saturation, honest variances, shared darks as one error.
#include "scatmap/brdf/merge.h"

#include <gtest/gtest.h>

#include "tests/counts/made_frames.h"

namespace scatmap {
namespace {

using test::kSensor;

// Three exposures with 100 : 10 : 1 of the light; one dark of equal exposure time shared by all.
Merged merged_of(double longest_e, std::uint64_t seed, int side) {
  std::mt19937_64 rng(seed);
  const auto level = [&](double e) { return Grid<double>(side, side, e); };
  const MasterDark dark = combine_darks(test::made_frames(5, level(0), 4, kSensor, rng), kSensor);
  std::vector<Counts> counts;
  for (const double share : {1.0, 0.1, 0.01})
    counts.push_back(reduce(test::made_frames(2, level(longest_e * share), 4, kSensor, rng), dark, kSensor, {}, 1.0));
  const std::vector<ScaledCounts> scaled{
      {&counts[0], 1.5, 0}, {&counts[1], 15, 0}, {&counts[2], 150, 0}};  // to electrons of the longest
  return merge(scaled);
}

TEST(Merge, UnbiasedWithHonestVarianceFromFloorToSaturation) {
  constexpr int kSide = 200;
  for (const double e : {0.0, 3.0, 30.0, 1000.0, 60000.0, 1e6, 5e6}) {
    const Merged m = merged_of(e, 40 + static_cast<std::uint64_t>(std::log1p(e) * 10), kSide);
    std::vector<double> z, error;
    double variance = 0;
    for (std::size_t i = 0; i < m.value.size(); ++i) {
      if (m.mask[i] != 0) continue;
      z.push_back((m.value[i] - e) / std::sqrt(m.variance[i]));
      error.push_back(m.value[i] - e);
      variance += m.variance[i];
    }
    ASSERT_GE(z.size(), 39000u) << e;
    const test::Moments p = test::moments(z), d = test::moments(error);
    EXPECT_NEAR(std::sqrt(p.mean * p.mean + p.sd * p.sd), 1, 0.02) << e;
    EXPECT_LE(std::abs(d.mean), 4 * std::sqrt(variance) / p.n + 1e-4 * e) << e;
  }
}

TEST(Merge, BetterThanTheBestSingleExposure) {
  const Merged m = merged_of(1000, 1, 50);
  // Longest alone: (64 + 4 + 1000)/2 + dark; the others add information.
  EXPECT_LT(test::moments(std::vector<float>(m.variance.begin(), m.variance.end())).mean,
            (64 + 4 + 1000) / 2.0 + 68 / 5.0);
}

TEST(Merge, ASaturatedExposureDropsOutAndAllSaturatedIsMasked) {
  const Merged bright = merged_of(1e6, 2, 20);  // 667k DN in the longest: saturated
  for (std::size_t i = 0; i < bright.mask.size(); ++i) {
    EXPECT_EQ(bright.mask[i], 0);
    EXPECT_EQ(bright.share[0][i], 0);
    EXPECT_NEAR(bright.share[1][i] + bright.share[2][i], 1, 1e-6);
  }
  const Merged all = merged_of(1e9, 3, 20);
  for (std::size_t i = 0; i < all.mask.size(); ++i) {
    EXPECT_NE(all.mask[i] & kSaturated, 0);
    EXPECT_TRUE(std::isnan(all.value[i]));
  }
}

TEST(Merge, OneExposureIsItself) {
  std::mt19937_64 rng(4);
  const Grid<double> level(30, 30, 50.0);
  const MasterDark dark = combine_darks(test::made_frames(5, Grid<double>(30, 30, 0.0), 4, kSensor, rng), kSensor);
  const Counts c = reduce(test::made_frames(2, level, 4, kSensor, rng), dark, kSensor, {}, 1.0);
  const std::vector<ScaledCounts> scaled{{&c, 2.0, 0}};
  const Merged m = merge(scaled);
  for (std::size_t i = 0; i < m.value.size(); ++i)
    EXPECT_NEAR(m.value[i], 2 * c.rate_dn_per_s[i], 1e-9 * std::abs(m.value[i]) + 1e-12);
  EXPECT_TRUE(m.share.empty());
}

}  // namespace
}  // namespace scatmap
