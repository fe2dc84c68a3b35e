// σ of the scatter angles against Monte Carlo over the calibration covariance, angles by the simulator's own
// derivation.
#include "scatmap/angles/angle_uncertainty.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "tests/support/random_instrument.h"

namespace scatmap {
namespace {

synth::Bench bench() {
  synth::Bench b;
  b.columns = 101;
  b.rows = 81;
  b.pitch_um = {100, 120};
  b.distance_mm = 325;
  b.rotation_deg = {1, -2, 5};
  b.beam_elevation_deg = 0.1;
  return b;
}

Calibration calibration() {
  Calibration c;
  c.parameters = {"detector.distance_mm", "arm.zero_deg", "stage.zero_deg", "detector.offset_mm.1", "sample.tilt_deg"};
  Eigen::VectorXd sigma(5);
  sigma << 0.5, 0.01, 0.006, 0.04, 0.008;
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(5, 5);
  correlation(1, 2) = correlation(2, 1) = 0.8;
  correlation(3, 4) = correlation(4, 3) = -0.5;
  c.covariance = sigma.asDiagonal() * correlation * sigma.asDiagonal();
  return c;
}

TEST(AngleUncertainty, IsTheSpreadOfMonteCarlo) {
  constexpr double kStage_deg = 30, kArm_deg = 62;
  constexpr int kTrials = 4000;
  Instrument in = test::instrument_of(bench());
  in.calibration = calibration();
  const Pose pose{kStage_deg * kRadPerDeg, kArm_deg * kRadPerDeg};
  const auto u = angle_uncertainty(in, pose, Grid<Mask>(81, 101, Mask{0}));
  ASSERT_TRUE(u.has_value());
  const SampleView nominal = sample_view(in, pose);
  const Eigen::MatrixXd factor = calibration().covariance.llt().matrixL();
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  for (const auto& [column, row] : {std::pair{50, 40}, {3, 5}, {97, 70}}) {
    const synth::TruthGeometry centre(bench(), kStage_deg, kArm_deg);
    const auto expected = centre.pixel(column, row);
    double theta2 = 0, phi2 = 0, both = 0, pixel2 = 0;
    for (int t = 0; t < kTrials; ++t) {
      Eigen::VectorXd z(5);
      for (double& v : z) v = normal(rng);
      const Eigen::VectorXd d = factor * z;
      synth::Bench b = bench();
      b.distance_mm += d[0];
      b.arm_zero_deg += d[1];
      b.stage_zero_deg += d[2];
      b.offset_mm[1] += d[3];
      b.sample_tilt_deg += d[4];
      const synth::TruthGeometry drawn(b, kStage_deg, kArm_deg);
      const auto p = drawn.pixel(column, row);
      const double d_theta = static_cast<double>(p->theta_s_rad - expected->theta_s_rad),
                   d_phi = static_cast<double>(p->phi_s_rad - expected->phi_s_rad);
      const auto back =
          pixel_of_direction(nominal, {static_cast<double>(p->direction.x), static_cast<double>(p->direction.y),
                                       static_cast<double>(p->direction.z)});
      theta2 += d_theta * d_theta;
      phi2 += d_phi * d_phi;
      both += d_theta * d_phi;
      pixel2 += (back->column - column) * (back->column - column) + (back->row - row) * (back->row - row);
    }
    constexpr double kTolerance = 0.04;  // three standard errors of 4000 trials
    EXPECT_NEAR(u->theta_s_rad(row, column) / std::sqrt(theta2 / kTrials), 1, kTolerance);
    EXPECT_NEAR(u->phi_s_rad(row, column) / std::sqrt(phi2 / kTrials), 1, kTolerance);
    EXPECT_NEAR(u->correlation(row, column), both / std::sqrt(theta2 * phi2), 0.05);
    EXPECT_NEAR(u->direction_px(row, column) / std::sqrt(pixel2 / kTrials), 1, kTolerance);
  }
}

TEST(AngleUncertainty, PhiAtThePoleIsUnknownAndNotInfinite) {
  Instrument in = test::instrument_of(bench());
  in.geometry.rotation_pitch = in.geometry.rotation_yaw = in.geometry.beam_elevation = 0;
  in.calibration = calibration();
  const auto u = angle_uncertainty(in, {0.3, 0.3}, Grid<Mask>(81, 101, Mask{0}));  // looks along the normal
  EXPECT_LE(u->phi_s_rad(40, 50), 1.82f);
  EXPECT_GT(u->phi_s_rad(40, 50), 1.81f);
  EXPECT_GT(u->theta_s_rad(40, 50), 0);
  EXPECT_LT(u->phi_s_rad(0, 0), 0.1f);
}

TEST(AngleUncertainty, NoneWithoutACalibrationAndNanWhereMasked) {
  Instrument in = test::instrument_of(bench());
  EXPECT_FALSE(angle_uncertainty(in, {0.3, 0.6}, Grid<Mask>(81, 101, Mask{0})).has_value());
  in.calibration = calibration();
  Grid<Mask> mask(81, 101, Mask{0});
  mask(1, 2) = kBelowHorizon;
  EXPECT_TRUE(std::isnan(angle_uncertainty(in, {0.3, 0.6}, mask)->theta_s_rad(1, 2)));
}

// The default tolerance of the angle methods hangs on it.
TEST(AngleUncertainty, TheSmallestDirectionSigmaIsThatOfTheMap) {
  Instrument in = test::instrument_of(bench());
  EXPECT_FALSE(smallest_direction_sigma_px(in, {0.5, 1.1}).has_value());
  in.calibration = calibration();
  const auto u = angle_uncertainty(in, {0.5, 1.1}, Grid<Mask>(81, 101, Mask{0}));
  ASSERT_TRUE(u.has_value());
  const double smallest = *std::min_element(u->direction_px.begin(), u->direction_px.end());
  EXPECT_NEAR(*smallest_direction_sigma_px(in, {0.5, 1.1}), smallest, 0.02 * smallest);
}

}  // namespace
}  // namespace scatmap
