// What the spot finder says of frames whose truth is known: saturated cores, neighbours, clipped and elongated spots,
// hot pixels, and frames without a spot. Does not prove that sigma holds on average (spots_statistics_test.cpp), nor
// anything about light that is no Gaussian beyond the real frames' stability (spots_real_frames_test.cpp).
#include "calib/spots.h"

#include <gtest/gtest.h>

#include "scatmap/base/error.h"
#include "spot_frame.h"

namespace scatmap::calib {
namespace {

using test::TrueCamera;
using test::TrueSpot;

constexpr SpotMethod kBoth[] = {SpotMethod::kMaximumLikelihood, SpotMethod::kMoments};

SpotsInFrame found_in(const Frame& frame, const TrueCamera& camera,
                      SpotMethod method = SpotMethod::kMaximumLikelihood) {
  const MasterDark dark = stated_dark(camera.bias_dn, 0, camera.rows, camera.columns, 1, camera.sensor());
  return find_spots(spot_image(frame, dark, camera.sensor()), method);
}

SpotsInFrame found_in(const std::vector<TrueSpot>& spots, const TrueCamera& camera, SpotMethod method, unsigned seed) {
  std::mt19937_64 random(seed);
  return found_in(test::camera_frame(camera, test::expected_e(camera, spots), random), camera, method);
}

// Squared distance from the truth in the stated covariance; 18.4 is exceeded once in 10,000.
double deviation2(const Spot& s, const TrueSpot& truth) {
  const Eigen::Vector2d d(s.column_px - truth.column_px, s.row_px - truth.row_px);
  return d.dot(s.covariance_px2.inverse() * d);
}
constexpr double kRare = 18.4;

TEST(Spots, SaturatedCoreIsLeftOutAndFlagged) {
  TrueCamera camera;
  camera.saturation_dn = 4000;  // the peak would be 16 times that
  const TrueSpot truth{31.3, 33.8, 3e6, 2.4, 2.1, 0.5};
  for (const SpotMethod method : kBoth) {
    const SpotsInFrame found = found_in({truth}, camera, method, 11);
    ASSERT_EQ(found.spots.size(), 1u);
    EXPECT_EQ(found.spots[0].flags, kSpotSaturated);
    EXPECT_LE(deviation2(found.spots[0], truth), kRare);
    EXPECT_LE(found.spots[0].sigma_px(), 0.02);
    EXPECT_NEAR(found.spots[0].flux_e, truth.flux_e, 5 * found.spots[0].u_flux_e);
  }
}

TEST(Spots, NeighboursAreToldApartAndFittedTogether) {
  const TrueCamera camera;
  const TrueSpot bright{28.4, 31.2, 2e5, 2.2, 2.2, 0};
  for (const double apart : {9.5, 12.0, 20.0}) {
    const TrueSpot dim{bright.column_px + apart, bright.row_px + 1.3, 4e4, 2.2, 2.2, 0};
    for (const SpotMethod method : kBoth) {
      const SpotsInFrame found = found_in({dim, bright}, camera, method, 5);
      ASSERT_EQ(found.spots.size(), 2u) << apart;
      EXPECT_LE(deviation2(found.spots[0], bright), kRare) << apart;
      EXPECT_LE(deviation2(found.spots[1], dim), kRare) << apart;
      EXPECT_EQ(found.spots[0].flags & kSpotSecondary, 0);
      EXPECT_NE(found.spots[1].flags & kSpotSecondary, 0);
    }
  }
}

// No second peak, but two Gaussians all the same.
TEST(Spots, SpotsWithoutASaddleAreToldApartByTheFit) {
  const TrueCamera camera;
  const TrueSpot bright{28.4, 31.2, 2e5, 2.2, 2.2, 0};
  for (const double share : {1.0, 0.2}) {
    const TrueSpot dim{bright.column_px + 6.6, bright.row_px + 0.7, share * 1.9e5, 2.2, 2.2, 0};
    const SpotsInFrame found = found_in({dim, bright}, camera, SpotMethod::kMaximumLikelihood, 15);
    ASSERT_EQ(found.spots.size(), 2u) << share;
    EXPECT_LE(deviation2(found.spots[0], bright), kRare) << share;
    EXPECT_LE(deviation2(found.spots[1], dim), kRare) << share;
    EXPECT_EQ(found.spots[0].flags & kSpotMisfit, 0);
  }
}

TEST(Spots, ClippedSpotIsFlaggedAndItsFitStaysTrue) {
  const TrueCamera camera;
  for (const double column : {-1.0, 0.5, 3.0}) {
    const TrueSpot truth{column, 30.3, 1e5, 2.5, 2.5, 0};
    for (const SpotMethod method : kBoth) {
      const SpotsInFrame found = found_in({truth}, camera, method, 6);
      ASSERT_EQ(found.spots.size(), 1u);
      EXPECT_NE(found.spots[0].flags & kSpotClipped, 0);
      EXPECT_LE(deviation2(found.spots[0], truth), kRare) << column;
    }
  }
  EXPECT_EQ(found_in({{30, 30, 1e5, 2.5, 2.5, 0}}, camera, SpotMethod::kMaximumLikelihood, 7).spots.at(0).flags, 0);
}

TEST(Spots, ElongatedSpotIsFlaggedWithItsAxes) {
  const TrueCamera camera;
  const TrueSpot truth{30.7, 31.1, 3e5, 4.0, 1.6, -0.6};
  const Spot s = found_in({truth}, camera, SpotMethod::kMaximumLikelihood, 8).spots.at(0);
  EXPECT_EQ(s.flags, kSpotElongated);
  EXPECT_NEAR(s.axes.major_px, 4.0, 0.05);
  EXPECT_NEAR(s.axes.minor_px, 1.6, 0.05);
  EXPECT_NEAR(s.axes.angle_rad, -0.6, 0.02);
}

// Hot pixels alone and in pairs, brighter than the spot, and one on its flank.
TEST(Spots, HotPixelsAreNoSpotsAndBendNone) {
  const TrueCamera camera;
  const TrueSpot truth{33.3, 30.6, 2e4, 1.8, 1.8, 0};
  std::mt19937_64 random(9);
  Frame frame = test::camera_frame(camera, test::expected_e(camera, {truth}), random);
  for (const auto& [row, column] : {std::pair{5, 6}, {20, 50}, {50, 12}, {50, 13}, {32, 35}})
    frame.dn(row, column) += 30000;
  for (const SpotMethod method : kBoth) {
    const SpotsInFrame found = found_in(frame, camera, method);
    ASSERT_EQ(found.spots.size(), 1u);
    EXPECT_GE(found.hot_pixels, 3u);
    EXPECT_LE(deviation2(found.spots[0], truth), kRare);
    EXPECT_EQ(found.spots[0].flags & kSpotMisfit, 0);
  }
}

TEST(Spots, FaintHotPixelOnTheSpotIsLeftOut) {
  const TrueCamera camera;
  const TrueSpot truth{30.2, 30.6, 3e5, 2.5, 2.5, 0};
  std::mt19937_64 random(10);
  Frame frame = test::camera_frame(camera, test::expected_e(camera, {truth}), random);
  frame.dn(33, 32) += 700;  // 14 sigma there
  const Spot s = found_in(frame, camera).spots.at(0);
  EXPECT_LE(deviation2(s, truth), kRare);
  EXPECT_EQ(s.flags, 0);
}

TEST(Spots, FrameWithoutSpotGivesNone) {
  const TrueCamera camera;
  for (unsigned seed = 0; seed < 20; ++seed) {
    EXPECT_TRUE(found_in(std::vector<TrueSpot>{}, camera, SpotMethod::kMaximumLikelihood, seed).spots.empty()) << seed;
  }
}

TEST(Spots, WithoutDarksTheBackgroundIsTakenFromTheFrame) {
  TrueCamera camera;
  camera.background_e = 400;
  const TrueSpot truth{30.7, 31.9, 5e4, 2.2, 2.0, 0.3};
  std::mt19937_64 random(12);
  const Frame frame = test::camera_frame(camera, test::expected_e(camera, {truth}), random);
  const Spot s =
      find_spots(spot_image(frame, std::nullopt, camera.sensor()), SpotMethod::kMaximumLikelihood).spots.at(0);
  EXPECT_LE(deviation2(s, truth), kRare);
  EXPECT_EQ(s.flags, 0);
}

// Every pixel has its own dark level, and some are hot beyond the spot's height.
TEST(Spots, DarksTakeOffTheirPatternAndHotPixels) {
  const TrueCamera camera;
  const TrueSpot truth{30.7, 31.9, 2e4, 2.2, 2.0, 0.3};
  std::mt19937_64 random(13);
  std::vector<double> thermal(64 * 64);
  for (double& e : thermal) e = std::uniform_real_distribution<double>(0, 200)(random);
  for (const std::size_t i : {32 * 64 + 31, 33 * 64 + 30, 33 * 64 + 31, 10 * 64 + 10, 10 * 64 + 11, 11 * 64 + 10})
    thermal[i] = 20000;
  std::vector<Frame> darks;
  for (int k = 0; k < 9; ++k) darks.push_back(test::camera_frame(camera, thermal, random));
  std::vector<double> light = test::expected_e(camera, {truth});
  for (std::size_t i = 0; i < light.size(); ++i) light[i] += thermal[i];
  const Frame frame = test::camera_frame(camera, light, random);
  for (const SpotMethod method : kBoth) {
    const SpotsInFrame found =
        find_spots(spot_image(frame, combine_darks(darks, camera.sensor()), camera.sensor()), method);
    ASSERT_EQ(found.spots.size(), 1u);
    EXPECT_LE(deviation2(found.spots[0], truth), kRare);
    EXPECT_EQ(found.spots[0].flags, 0);
  }
}

TEST(Spots, PixelsThatAreNoNumbersAreLeftOut) {
  const TrueCamera camera;
  const TrueSpot truth{30.7, 31.9, 2e5, 12, 11, 0.3};  // wide enough to be summed in bins
  std::mt19937_64 random(14);
  Frame frame = test::camera_frame(camera, test::expected_e(camera, {truth}), random);
  for (const auto& [row, column] : {std::pair{30, 31}, {31, 31}, {0, 0}, {63, 63}})
    frame.dn(row, column) = std::nanf("");
  const Spot s = found_in(frame, camera).spots.at(0);
  EXPECT_LE(deviation2(s, truth), kRare);
  for (float& v : frame.dn.floats()) v = std::nanf("");
  EXPECT_THROW(found_in(frame, camera), Error);
}

TEST(Spots, TinyAndConstantFramesGiveNone) {
  for (const int size : {1, 2, 5, 40}) {
    TrueCamera camera;
    camera.columns = camera.rows = size;
    const Frame frame{Grid<float>(size, size, 300.0F), 1, "constant", {}};
    EXPECT_TRUE(found_in(frame, camera).spots.empty()) << size;
    EXPECT_TRUE(find_spots(spot_image(frame, std::nullopt, camera.sensor()), SpotMethod::kMoments).spots.empty())
        << size;
  }
}

TEST(Spots, SensorWithoutGainIsRefused) {
  const TrueCamera camera;
  std::mt19937_64 random(1);
  const Frame frame = test::camera_frame(camera, test::expected_e(camera, {}), random);
  SensorModel sensor = camera.sensor();
  sensor.gain_e_per_dn = 0;
  EXPECT_THROW(spot_image(frame, std::nullopt, sensor), Error);
}

}  // namespace
}  // namespace scatmap::calib
