// Master darks: the claimed variance is the observed one, outliers and hot pixels are found, nothing else is touched.
// Does not prove anything about sensors whose noise is not Poisson and Gaussian.
#include "scatmap/counts/dark.h"

#include <gtest/gtest.h>

#include "scatmap/base/error.h"
#include "tests/counts/made_frames.h"

namespace scatmap {
namespace {

using test::kSensor;
constexpr double kDark_e = 40;
constexpr double kExpectedLevel = 300 + kDark_e / 1.5;
const double kSingleVariance = (64 + kDark_e) / 2.25 + 1.0 / 12;

std::vector<Frame> darks(int count, int side, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  return test::made_frames(count, Grid<double>(side, side, 0.0), kDark_e, kSensor, rng);
}

TEST(Dark, LevelAndItsVarianceAreHonest) {
  const MasterDark dark = combine_darks(darks(9, 200, 1), kSensor);
  std::vector<double> level(dark.level_dn.begin(), dark.level_dn.end()),
      claimed(dark.level_variance_dn2.begin(), dark.level_variance_dn2.end());
  const test::Moments m = test::moments(level);
  EXPECT_NEAR(m.mean, kExpectedLevel, 4 * m.sd / std::sqrt(m.n));
  EXPECT_NEAR(m.sd / std::sqrt(kSingleVariance / 9), 1, 4 / std::sqrt(2 * m.n));
  EXPECT_NEAR(test::moments(claimed).mean / (kSingleVariance / 9), 1, 0.02);
  EXPECT_TRUE(dark.pooled_from_frames);
  EXPECT_NEAR(dark.pooled_variance_dn2 / kSingleVariance, 1, 0.02);
}

TEST(Dark, OneDarkFallsBackToTheStatedReadNoise) {
  const MasterDark dark = combine_darks(darks(1, 60, 2), kSensor);
  EXPECT_FALSE(dark.pooled_from_frames);
  EXPECT_NEAR(dark.pooled_variance_dn2 / kSingleVariance, 1, 0.03);
}

TEST(Dark, CosmicHitsInOneDarkDoNotMoveTheLevel) {
  auto frames = darks(7, 100, 3);
  for (int k = 0; k < 100; ++k) frames[2].dn(k, k) += 5000;
  const MasterDark dark = combine_darks(frames, kSensor);
  std::vector<double> hit;
  for (int k = 0; k < 100; ++k) {
    hit.push_back(dark.level_dn(k, k));
    EXPECT_EQ(dark.mask(k, k), 0);
  }
  EXPECT_NEAR(test::moments(hit).mean, kExpectedLevel, 4 * std::sqrt(kSingleVariance / 6 / 100));
}

TEST(Dark, HotAndUnstablePixelsAreMasked) {
  auto frames = darks(7, 100, 4);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].dn(10, 10) += 2000;                      // hot
    frames[k].dn(20, 20) += k % 2 == 0 ? 100.f : 0.f;  // flickers
    frames[k].dn(30, 30) = std::nanf("");
  }
  const MasterDark dark = combine_darks(frames, kSensor);
  EXPECT_EQ(dark.mask(10, 10), kHot);
  EXPECT_EQ(dark.mask(20, 20), kHot);
  EXPECT_EQ(dark.mask(30, 30), kHot);
  int hot = 0;
  for (const Mask m : dark.mask) hot += m != 0;
  EXPECT_EQ(hot, 3);
}

TEST(Dark, ExtraDarkChargeRaisesTheVarianceOfItsPixel) {
  auto frames = darks(7, 100, 5);
  std::mt19937_64 rng(6);
  for (auto& f : frames) f.dn(5, 5) += static_cast<float>(std::poisson_distribution<int>(30)(rng)) / 1.5f;
  const MasterDark dark = combine_darks(frames, kSensor);
  EXPECT_NEAR(dark.single_variance_dn2(5, 5) - dark.pooled_variance_dn2, 30 / 2.25, 8);
}

TEST(Dark, ShapesMustAgreeAndSomeDarkMustBe) {
  auto frames = darks(2, 20, 7);
  frames[1].dn = Grid<float>(20, 21, 0.f);
  EXPECT_THROW(combine_darks(frames, kSensor), Error);
  EXPECT_THROW(combine_darks({}, kSensor), Error);
}

}  // namespace
}  // namespace scatmap
