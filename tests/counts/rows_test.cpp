// Reduction and dark combination in vector loops against the same sums written here pixel by pixel, on frames full of
// outliers, NaN and saturation. Does not prove that the rules are wise: dark_test.cpp and reduce_test.cpp do.
#include <gtest/gtest.h>

#include <algorithm>

#include "scatmap/counts/reduce.h"
#include "tests/counts/made_frames.h"

namespace scatmap {
namespace {

using test::kSensor;

struct Kept {
  double mean = 0;
  int count = 0;
};

// Values within `limit` of `centre`.
Kept kept(const std::vector<double>& values, double centre, double limit) {
  Kept out;
  for (const double v : values) {
    if (!(std::abs(v - centre) <= limit)) continue;
    out.mean += v;
    ++out.count;
  }
  out.mean /= out.count;
  return out;
}

Kept frames_mean(std::vector<double> v, double dark, double variance, const SensorModel& s) {
  if (v.size() == 1) return kept(v, 0, HUGE_VAL);
  std::vector<double> sorted = v;
  std::sort(sorted.begin(), sorted.end());
  const double centre = v.size() == 2 ? sorted[0] : sorted[v.size() / 2], net = std::max(0.0, centre - dark);
  const double u = std::sqrt(variance + net / s.gain_e_per_dn + std::pow(kFrameDriftAllowance * net, 2));
  Kept out = kept(v, centre, kFrameOutlierSigmas * u * (v.size() == 2 ? std::sqrt(2.0) : 1.0));
  if (v.size() == 2 && out.count == 1) out.count = 0;
  return out;
}

std::vector<Frame> spoilt_frames(int count, int rows, int columns, std::mt19937_64& rng) {
  Grid<double> e(rows, columns);
  for (std::size_t i = 0; i < e.size(); ++i)
    e[i] = std::pow(10, static_cast<double>(i % 60) / 10);  // to 1e6: saturated
  auto frames = test::made_frames(count, e, 4, kSensor, rng);
  for (Frame& f : frames) {
    for (float& v : f.dn.floats()) {
      if (rng() % 40 == 0) v = v + 0.5f * static_cast<float>(rng() % 800);  // around the limit
    }
  }
  return frames;
}

TEST(Rows, ReduceAgreesWithTheSumWrittenOut) {
  std::mt19937_64 rng(1);
  for (const int count : {1, 2, 3, 4, 7}) {
    for (const bool linear : {true, false}) {
      SensorModel sensor = kSensor;
      if (!linear) sensor.linearity = {2e-7, -1e-12, 3e-18};
      const MasterDark dark = combine_darks(test::made_frames(4, Grid<double>(37, 1111, 0.0), 4, kSensor, rng), sensor);
      auto frames = spoilt_frames(count, 37, 1111, rng);
      frames[0].dn(5, 600) = std::nanf("");
      const Counts c = reduce(frames, dark, sensor, {}, 0.3);
      std::size_t rejected = 0;
      for (std::size_t i = 0; i < c.mask.size(); ++i) {
        std::vector<double> v;
        bool saturated = false, absent = false;
        for (const Frame& f : frames) {
          v.push_back(sensor.linearised(f.dn[i]));
          saturated = saturated || f.dn[i] >= sensor.saturation_dn;
          absent = absent || std::isnan(f.dn[i]);
        }
        if (absent) {
          EXPECT_NE(c.mask[i] & kNoData, 0);
          continue;
        }
        const Kept k = frames_mean(v, dark.level_dn[i], dark.single_variance_dn2[i], sensor);
        rejected += v.size() - static_cast<std::size_t>(k.count);
        ASSERT_EQ((c.mask[i] & kCosmic) != 0, k.count == 0) << i;
        ASSERT_EQ((c.mask[i] & kSaturated) != 0, saturated) << i;
        if (k.count == 0) continue;
        const double rate = (k.mean - dark.level_dn[i]) / 0.3;
        ASSERT_LE(std::abs(c.rate_dn_per_s[i] - rate), 1e-11 * (std::abs(rate) + 300 / 0.3)) << i;
        const double n = k.count;
        ASSERT_NEAR(c.frame_floor[i] * n * 0.09 / dark.single_variance_dn2[i], 1, 1e-6) << i;
        ASSERT_NEAR(c.shot[i] * n * 0.3 * sensor.gain_e_per_dn, 1, 1e-6) << i;
        ASSERT_NEAR(c.dark_floor[i] * 0.09 / dark.level_variance_dn2[i], 1, 1e-6) << i;
      }
      EXPECT_GE(c.rejected_values, rejected);
      if (count > 2) {
        EXPECT_GT(rejected, 100u);
      }
    }
  }
}

TEST(Rows, DarksAgreeWithTheSumWrittenOut) {
  std::mt19937_64 rng(2);
  for (const int count : {1, 2, 3, 4, 8}) {
    auto darks = test::made_frames(count, Grid<double>(41, 733, 0.0), 30, kSensor, rng);
    for (Frame& f : darks) {
      for (float& v : f.dn.floats()) {
        if (rng() % 50 == 0) v = v + static_cast<float>(rng() % 120);
      }
    }
    const MasterDark m = combine_darks(darks, kSensor);
    const double floor = kSensor.read_noise_dn() * kSensor.read_noise_dn() + 1.0 / 12;
    int dropped = 0;
    for (std::size_t i = 0; i < m.mask.size(); ++i) {
      std::vector<double> v, sorted;
      for (const Frame& f : darks) v.push_back(f.dn[i]);
      sorted = v;
      std::sort(sorted.begin(), sorted.end());
      const std::size_t n = v.size();
      const double median = n % 2 == 1 ? sorted[n / 2] : 0.5 * (sorted[n / 2] + sorted[n / 2 - 1]);
      const double u = std::sqrt(floor + std::max(0.0, median - kSensor.bias_dn) / kSensor.gain_e_per_dn);
      const Kept k = n < 3 ? kept(v, 0, HUGE_VAL) : kept(v, median, kDarkOutlierSigmas * u);
      dropped += static_cast<int>(n) - k.count;
      ASSERT_NEAR(m.level_dn[i], k.mean, 1e-4) << count << " " << i;
      ASSERT_NEAR(m.level_variance_dn2[i] * static_cast<float>(k.count) / m.single_variance_dn2[i], 1, 1e-5) << i;
    }
    if (count > 2) {
      EXPECT_GT(dropped, 20) << count;
    }
  }
}

}  // namespace
}  // namespace scatmap
