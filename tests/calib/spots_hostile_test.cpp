// Frames that bend a centroid: dead pixels, darks that are too high, neighbours too close to be told apart. What is
// stated as sigma must cover the error there too. Does not prove anything about light that is no sum of Gaussians.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "calib/spots.h"
#include "spot_frame.h"

namespace scatmap::calib {
namespace {

using test::TrueCamera;
using test::TrueSpot;

constexpr SpotMethod kBoth[] = {SpotMethod::kMaximumLikelihood, SpotMethod::kMoments};
constexpr double kRare = 18.4;  // chi-square of two degrees of freedom, once in 10,000
constexpr unsigned kFrames = 20;

double deviation2(const Spot& s, const TrueSpot& truth) {
  const Eigen::Vector2d d(s.column_px - truth.column_px, s.row_px - truth.row_px);
  return d.dot(s.covariance_px2.inverse() * d);
}

Frame frame_of(const std::vector<TrueSpot>& spots, const TrueCamera& camera, unsigned seed) {
  std::mt19937_64 random(seed);
  return test::camera_frame(camera, test::expected_e(camera, spots), random);
}

SpotsInFrame found_in(const Frame& frame, const TrueCamera& camera, double dark_dn, SpotMethod method) {
  const MasterDark dark = stated_dark(dark_dn, 0, camera.rows, camera.columns, 1, camera.sensor());
  return find_spots(spot_image(frame, dark, camera.sensor()), method);
}

TEST(SpotsHostile, DeadAndWeakPixelsOnTheSpotAreLeftOut) {
  const TrueCamera camera;
  const TrueSpot truth{30.3, 30.6, 1e5, 1.7, 1.7, 0};
  for (unsigned seed = 0; seed < kFrames; ++seed) {
    Frame frame = frame_of({truth}, camera, seed);
    if (seed % 2 == 0)
      frame.dn(31, 31) = static_cast<float>(camera.bias_dn);
    else
      frame.dn(31, 32) = 1500;  // some 1000 DN below the light there
    for (const SpotMethod method : kBoth) {
      const Spot s = found_in(frame, camera, camera.bias_dn, method).spots.at(0);
      EXPECT_LE(deviation2(s, truth), kRare) << seed;
      EXPECT_EQ(s.flags, 0) << seed;
    }
  }
}

// Light is never negative: a background below the dark says that the dark is too high, and its light has shot noise.
TEST(SpotsHostile, DarkAboveTheSpotLeavesSigmaTrue) {
  const TrueCamera camera;
  const TrueSpot truth{30.3, 30.6, 1e5, 1.7, 1.7, 0};
  for (const SpotMethod method : kBoth) {
    double sum = 0;
    for (unsigned seed = 0; seed < kFrames; ++seed) {
      const Spot s = found_in(frame_of({truth}, camera, seed), camera, 20000, method).spots.at(0);
      EXPECT_EQ(s.flags, 0) << seed;
      EXPECT_NEAR(s.background_e, (camera.bias_dn - 20000) * camera.gain_e_per_dn, 10) << seed;
      sum += deviation2(s, truth);
    }
    // chi-square of 40 degrees of freedom: 99.9 % lie between 16.9 and 76.
    EXPECT_GE(sum, 16.9);
    EXPECT_LE(sum, 76);
  }
}

// The fit trades light between two close spots: moments from which the fitted neighbour is taken off know no more.
TEST(SpotsHostile, MomentsBesideACloseNeighbourAreAsUncertainAsItsFit) {
  const TrueCamera camera;
  const TrueSpot one{30.3, 30.6, 1e5, 1.7, 1.7, 0}, other{32.34, 32.13, 1e5, 1.7, 1.7, 0};
  for (unsigned seed = 0; seed < kFrames; ++seed) {
    for (const Spot& s :
         found_in(frame_of({one, other}, camera, seed), camera, camera.bias_dn, SpotMethod::kMoments).spots)
      EXPECT_LE(std::min(deviation2(s, one), deviation2(s, other)), kRare) << seed;
  }
}

// Two Gaussians explain the light, but not how it is shared: the centre is as open as that.
TEST(SpotsHostile, FaintNeighbourThatCannotBeToldApartWidensSigma) {
  const TrueCamera camera;
  const TrueSpot one{30.3, 30.6, 1e5, 1.7, 1.7, 0}, other{32.34, 32.13, 1e4, 1.7, 1.7, 0};
  for (const SpotMethod method : kBoth) {
    for (unsigned seed = 0; seed < kFrames; ++seed) {
      const Spot s = found_in(frame_of({one, other}, camera, seed), camera, camera.bias_dn, method).spots.at(0);
      EXPECT_NE(s.flags & (kSpotMisfit | kSpotNeighbour), 0) << seed;
      EXPECT_LE(deviation2(s, one), kRare) << seed;
    }
  }
}

}  // namespace
}  // namespace scatmap::calib
