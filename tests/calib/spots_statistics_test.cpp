// Scatter of centroids over many simulated frames against the Cramér-Rao bound, computed here on its own, and against
// their stated covariance. Light is Gaussian and noise is what the sensor model says: nothing is proved about other
// light.
#include "calib/spots.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "spot_frame.h"

namespace scatmap::calib {
namespace {

struct Scatter {
  int trials = 0;
  int missed = 0;
  double error2 = 0;      // sum over trials and both axes
  double deviation2 = 0;  // the same in the stated covariance
  double bound2 = 0;      // mean over trials of the bound's trace

  double against_bound() const { return std::sqrt(error2 / trials / bound2); }
  double z() const { return std::sqrt(deviation2 / (2 * trials)); }
  /// Standard error of a root mean square of 2 × trials normal numbers, relative.
  double standard_error() const { return 1 / std::sqrt(4.0 * trials); }
};

Scatter scatter(SpotMethod method, double flux_e, int trials, std::uint64_t seed) {
  test::TrueCamera camera;
  camera.columns = camera.rows = 30;
  camera.read_noise_e = 5;
  camera.background_e = 3;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(14, 15), turn(-1.5, 1.5), width(1.0, 2.2), stretch(1.0, 1.3);
  const MasterDark dark = stated_dark(camera.bias_dn, 0, camera.rows, camera.columns, 1, camera.sensor());
  Scatter out;
  for (int i = 0; i < trials; ++i) {
    const double minor = width(random);
    const test::TrueSpot truth{place(random), place(random), flux_e, minor * stretch(random) + 0.01,
                               minor,         turn(random)};
    const Frame frame = test::camera_frame(camera, test::expected_e(camera, {truth}), random);
    const SpotsInFrame found = find_spots(spot_image(frame, dark, camera.sensor()), method);
    if (found.spots.empty()) {
      ++out.missed;
      continue;
    }
    const Spot& s = found.spots.front();
    const Eigen::Vector2d error(s.column_px - truth.column_px, s.row_px - truth.row_px);
    ++out.trials;
    out.error2 += error.squaredNorm();
    out.deviation2 += error.dot(s.covariance_px2.inverse() * error);
    out.bound2 += test::cramer_rao_px2(camera, truth).trace();
  }
  out.bound2 /= out.trials;
  return out;
}

int trial_count() {
  const char* text = std::getenv("SCATMAP_SPOT_TRIALS");  // more by hand
  return text != nullptr ? std::atoi(text) : 300;
}

class SpotStatistics : public testing::TestWithParam<double> {};

// Above the bound by at most 5 %, and not below it, within three standard errors of the trials.
TEST_P(SpotStatistics, LikelihoodFitReachesTheBoundAndItsSigmaHolds) {
  const Scatter s = scatter(SpotMethod::kMaximumLikelihood, GetParam(), trial_count(), 71);
  std::printf("ml, %.0e e: rms/bound %.4f, z %.4f, missed %d, standard error %.4f\n", GetParam(), s.against_bound(),
              s.z(), s.missed, s.standard_error());
  EXPECT_EQ(s.missed, 0);
  EXPECT_LE(s.against_bound(), 1.05 + 3 * s.standard_error());
  EXPECT_GE(s.against_bound(), 1 - 3 * s.standard_error());
  EXPECT_NEAR(s.z(), 1, 3 * s.standard_error());
}

TEST_P(SpotStatistics, SigmaOfMomentsHolds) {
  const Scatter s = scatter(SpotMethod::kMoments, GetParam(), trial_count(), 72);
  std::printf("moments, %.0e e: rms/bound %.4f, z %.4f, missed %d\n", GetParam(), s.against_bound(), s.z(), s.missed);
  EXPECT_EQ(s.missed, 0);
  EXPECT_GE(s.against_bound(), 1 - 3 * s.standard_error());
  EXPECT_NEAR(s.z(), 1, 3 * s.standard_error());
}

INSTANTIATE_TEST_SUITE_P(Electrons, SpotStatistics, testing::Values(1e3, 1e4, 1e5, 1e6, 1e7));

}  // namespace
}  // namespace scatmap::calib
