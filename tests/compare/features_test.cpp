// Peaks of maps whose lobes are known functions of the pixel. Not proven here: that a real lobe, which is no exact
// Gaussian, has its summit where the fit puts it.
#include "scatmap/compare/features.h"

#include <gtest/gtest.h>

#include <limits>

#include "compare/synthetic_map.h"

namespace scatmap {
namespace {

using synthetic::Comb;
using synthetic::Lobe;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const Lobe kCentre{300.3, 280.7, 1.1e4, 9.6};
const Lobe kOffset{421.15, 390.6, 4.4e4, 9.6};
const Comb kComb{300.3, 280.7, 90, 19, 300, 6, 0, 800};
double cell(double c, double r) { return 0.5 + kCentre(c, r) + kOffset(c, r) + kComb(c, r); }

TEST(Features, TwoPeaksAboveACombAndNoise) {
  const BrdfMap map = synthetic::noisy(600, 560, cell, 0.05, 0.3, 1);
  const std::vector<Peak> peaks = find_peaks(map);
  ASSERT_EQ(peaks.size(), 2u);
  EXPECT_LE(std::hypot(peaks[0].column_px - kOffset.column, peaks[0].row_px - kOffset.row), 0.01);
  EXPECT_LE(std::hypot(peaks[1].column_px - kCentre.column, peaks[1].row_px - kCentre.row), 0.01);
  EXPECT_LE(std::abs(peaks[0].height_per_sr / kOffset.height - 1), 1e-3);
  // The fringe of order 0 lies under the centre lobe: summit 11300, and it is narrower than the lobe.
  EXPECT_LE(std::abs(peaks[1].height_per_sr / 11300 - 1), 0.01);
  EXPECT_LE(std::abs(peaks[0].radius_px / 9.6 - 1), 0.01);
  EXPECT_GE(peaks[1].prominence, 20);
}

TEST(Features, ModelMapWithoutNoiseIsFoundTheSame) {
  const std::vector<Peak> peaks = find_peaks(synthetic::noiseless(600, 560, cell));
  ASSERT_EQ(peaks.size(), 2u);
  EXPECT_LE(std::hypot(peaks[0].column_px - kOffset.column, peaks[0].row_px - kOffset.row), 1e-3);
  EXPECT_LE(std::abs(peaks[1].height_per_sr / 11300 - 1), 0.01);
  EXPECT_EQ(peaks[0].column_sigma_px, 0);
}

TEST(Features, CombsNoiseAndFlatFieldsHaveNoPeaks) {
  EXPECT_TRUE(find_peaks(synthetic::noisy(600, 560, kComb, 0.05, 0.3, 2)).empty());
  EXPECT_TRUE(find_peaks(synthetic::noiseless(600, 560, kComb)).empty());
  EXPECT_TRUE(find_peaks(synthetic::noisy(
                             300, 300, [](double, double) { return 0.0; }, 0, 1, 3))
                  .empty());
  EXPECT_TRUE(find_peaks(synthetic::noisy(
                             300, 300, [](double, double) { return 5.0; }, 0.2, 0, 4))
                  .empty());
  EXPECT_TRUE(find_peaks(synthetic::noiseless(300, 300, [](double, double) { return 5.0; })).empty());
}

TEST(Features, OneWideNoisyLobeIsOnePeak) {
  const Lobe wide{200, 210, 1000, 60};
  const std::vector<Peak> peaks = find_peaks(synthetic::noisy(400, 400, wide, 10, 5, 5));
  ASSERT_EQ(peaks.size(), 1u);
  EXPECT_LE(std::hypot(peaks[0].column_px - 200, peaks[0].row_px - 210), 0.5);
}

TEST(Features, OutliersMasksAndNansAreNoPeaks) {
  BrdfMap map = synthetic::noisy(600, 560, cell, 0.05, 0.3, 6);
  map.brdf_per_sr(50, 60) = 1e6;                                // hot pixel nobody masked
  map.brdf_per_sr(100, 500) = map.brdf_per_sr(101, 500) = 1e6;  // cosmic ray
  map.brdf_per_sr(393, 423) = 9e4;                              // hot pixel in the offset lobe's core
  for (int r = 440; r < 460; ++r) {
    for (int c = 40; c < 60; ++c) {
      map.brdf_per_sr(r, c) = 1e7;
      map.mask(r, c) = kSaturated;
    }
  }
  for (int c = 0; c < 600; ++c) map.brdf_per_sr(20, c) = kNaN;
  const std::vector<Peak> peaks = find_peaks(map);
  ASSERT_EQ(peaks.size(), 2u);
  EXPECT_LE(std::hypot(peaks[0].column_px - kOffset.column, peaks[0].row_px - kOffset.row), 0.01);
  EXPECT_LE(std::abs(peaks[0].height_per_sr / kOffset.height - 1), 2e-3);
}

TEST(Features, SaturatedCoreIsBridged) {
  BrdfMap map = synthetic::noisy(600, 560, cell, 0.05, 0.3, 7);
  for (int r = 0; r < 560; ++r) {
    for (int c = 0; c < 600; ++c) {
      if (kOffset(c, r) > 0.85 * kOffset.height) map.mask(r, c) = kSaturated;
    }
  }
  const std::vector<Peak> peaks = find_peaks(map);
  ASSERT_EQ(peaks.size(), 2u);
  EXPECT_LE(std::hypot(peaks[0].column_px - kOffset.column, peaks[0].row_px - kOffset.row), 0.02);
  EXPECT_LE(std::abs(peaks[0].height_per_sr / kOffset.height - 1), 0.01);
}

// 400 noise patterns on one lobe: the summit is unbiased and the stated sigmas are those of the scatter.
TEST(Features, SummitIsUnbiasedWithHonestSigma) {
  const Lobe lobe{30.37, 31.82, 100, 5};
  constexpr int kTrials = 400;
  double column_pull = 0, column_pull2 = 0, height_pull = 0, height_pull2 = 0, height_bias = 0, height_sigma = 0;
  for (int t = 0; t < kTrials; ++t) {
    const std::vector<Peak> p =
        find_peaks(synthetic::noisy(64, 64, lobe, 0.6, 1, 100 + static_cast<unsigned>(t)));  // 7.8 % at the summit
    ASSERT_EQ(p.size(), 1u);
    const double c = (p[0].column_px - lobe.column) / p[0].column_sigma_px;
    const double h = (p[0].height_per_sr - lobe.height) / p[0].height_sigma_per_sr;
    column_pull += c / kTrials;
    column_pull2 += c * c / kTrials;
    height_pull += h / kTrials;
    height_pull2 += h * h / kTrials;
    height_bias += (p[0].height_per_sr - lobe.height) / kTrials;
    height_sigma += p[0].height_sigma_per_sr / kTrials;
  }
  const double mean_tolerance = 4 / std::sqrt(kTrials);
  EXPECT_LE(std::abs(column_pull), mean_tolerance);
  EXPECT_LE(std::abs(height_bias), mean_tolerance * height_sigma) << "height pull " << height_pull;
  EXPECT_LE(std::abs(std::sqrt(column_pull2) - 1), 0.15);
  EXPECT_LE(std::abs(std::sqrt(height_pull2) - 1), 0.15);
}

TEST(Features, SpecularPixelHasSpecularAngles) {
  // Ideal geometry, arm at twice the stage: the frame's centre (99.5, 79.5) looks along the specular ray.
  const std::vector<Peak> peaks = find_peaks(synthetic::noiseless(200, 160, Lobe{99.5, 79.5, 50, 8}));
  ASSERT_EQ(peaks.size(), 1u);
  EXPECT_LE(std::abs(peaks[0].theta_s_deg - 20), 1e-6);
  EXPECT_LE(std::abs(peaks[0].phi_s_deg - 180), 1e-5);
}

TEST(Features, PairsAreNearestNeighboursEachUsedOnce) {
  const auto at = [](double column, double height) {
    Peak p;
    p.column_px = column;
    p.height_per_sr = height;
    p.theta_s_deg = 20 + column / 100;
    p.phi_s_deg = 180;
    return p;
  };
  const std::vector<PeakPair> pairs = pair_peaks({at(10, 8), at(100, 6), at(400, 5)}, {at(103, 3), at(12, 2)});
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].modelled.column_px, 12);
  EXPECT_EQ(pairs[1].modelled.column_px, 103);
  EXPECT_DOUBLE_EQ(pairs[0].height_ratio, 4);
  EXPECT_DOUBLE_EQ(pairs[1].distance_px, 3);
  EXPECT_LE(std::abs(pairs[1].angle_deg - 0.03), 1e-9);
}

}  // namespace
}  // namespace scatmap
