// u_pose against Monte Carlo: geometry drawn from the calibration covariance, angles by the simulator's own derivation.
// Proves the first-order propagation for σ as a calibration gives them; not for tilts of several degrees.
#include "scatmap/brdf/pose_uncertainty.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "data-synthetic/truth_geometry.h"
#include "scatmap/angles/angle_map.h"
#include "tests/support/random_instrument.h"

namespace scatmap {
namespace {

constexpr double kStage_deg = 40, kArm_deg = 80;

synth::Bench bench() {
  synth::Bench b;
  b.columns = 121;
  b.rows = 101;
  b.pitch_um = {110, 110};
  b.distance_mm = 325;
  b.rotation_deg = {1, -2, 0.5};
  b.beam_offset_mm = {0.05, -0.03};
  b.sample_tilt_deg = 0.02;
  return b;
}

Calibration calibration() {
  Calibration c{
      {"detector.distance_mm", "detector.rotation_deg.1", "arm.zero_deg", "stage.zero_deg", "detector.offset_mm.1"},
      {}};
  Eigen::VectorXd sigma(5);
  sigma << 0.8, 0.2, 0.01, 0.008, 0.05;
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(5, 5);
  correlation(0, 1) = correlation(1, 0) = -0.6;
  correlation(2, 3) = correlation(3, 2) = 0.7;
  c.covariance = sigma.asDiagonal() * correlation * sigma.asDiagonal();
  return c;
}

// A lobe of the half vector's slopes, as near-specular features are, on a diffuse floor.
double lobe(const synth::Vec3& source, const synth::Vec3& direction) {
  const synth::Vec3 u = source + direction;
  const double hx = static_cast<double>(u.x / u.z), hy = static_cast<double>(u.y / u.z);
  return 3 + 1e4 * std::exp(-(hx * hx + hy * hy) / (3e-3 * 3e-3));
}

TEST(PoseUncertainty, IsTheSpreadOfMonteCarlo) {
  Instrument in = test::instrument_of(bench());
  in.calibration = calibration();
  const Pose pose{kStage_deg * kRadPerDeg, kArm_deg * kRadPerDeg};
  const synth::TruthGeometry nominal(bench(), kStage_deg, kArm_deg);
  Grid<double> f(101, 121);
  Grid<double> projected(101, 121);
  for (int r = 0; r < 101; ++r) {
    for (int c = 0; c < 121; ++c) {
      const auto p = nominal.pixel(c, r);
      f(r, c) = lobe(nominal.to_source(), p->direction);
      projected(r, c) = static_cast<double>(p->solid_angle_sr * std::cos(p->theta_s_rad));
    }
  }
  const auto u = pose_uncertainty(in, pose, f);
  ASSERT_TRUE(u.has_value());

  // The bench believed is `nominal`; the true one is drawn. Reported at the believed direction: the light that the true
  // direction sends, divided by the believed Ω cosθ. Truth there: the lobe at the believed direction.
  const Eigen::MatrixXd factor = calibration().covariance.llt().matrixL();
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  constexpr int kTrials = 1500;
  const std::vector<std::pair<int, int>> pixels{{60, 50}, {66, 50}, {60, 58}, {50, 40}, {72, 61}, {10, 10}, {110, 90}};
  std::vector<double> square(pixels.size(), 0);
  for (int t = 0; t < kTrials; ++t) {
    Eigen::VectorXd z(5);
    for (double& v : z) v = normal(rng);
    const Eigen::VectorXd d = factor * z;
    synth::Bench b = bench();
    b.distance_mm += d[0];
    b.rotation_deg[1] += d[1];
    b.arm_zero_deg += d[2];
    b.stage_zero_deg += d[3];
    b.offset_mm[1] += d[4];
    const synth::TruthGeometry truth(b, kStage_deg, kArm_deg);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const auto [c, r] = pixels[i];
      const auto p = truth.pixel(c, r);
      const double reported = lobe(truth.to_source(), p->direction) *
                              static_cast<double>(p->solid_angle_sr * std::cos(p->theta_s_rad)) / projected(r, c);
      square[i] += (reported - f(r, c)) * (reported - f(r, c));
    }
  }
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto [c, r] = pixels[i];
    const double observed = std::sqrt(square[i] / kTrials);
    // Four standard errors of the trials, and 3 % for the curvature of the lobe.
    EXPECT_NEAR((*u)(r, c) / observed, 1, 4 / std::sqrt(2.0 * kTrials) + 0.03)
        << c << "," << r << " observed " << observed / f(r, c);
  }
}

TEST(PoseUncertainty, NoneWithoutACalibration) {
  const Instrument in = test::instrument_of(bench());
  EXPECT_FALSE(pose_uncertainty(in, {0.5, 1}, Grid<double>(101, 121, 1.0)).has_value());
}

TEST(PoseUncertainty, DistanceAloneActsThroughTheSolidAngle) {
  Instrument in = test::instrument_of(bench());
  in.geometry.rotation_pitch = in.geometry.rotation_yaw = 0;
  in.calibration = Calibration{{"detector.distance_mm"}, Eigen::MatrixXd::Constant(1, 1, 1.0)};
  const auto u = pose_uncertainty(in, {kStage_deg * kRadPerDeg, kArm_deg * kRadPerDeg}, Grid<double>(101, 121, 10.0));
  EXPECT_NEAR((*u)(50, 60), 10 * 2 / 325.0, 1e-4);  // dΩ/Ω = −2 dR/R
}

// The tiles' interpolation against the sum over causes, pixel by pixel, on wild benches.
TEST(PoseUncertainty, TilesStayWithinTheirBoundOfTheExactNorm) {
  std::mt19937_64 rng(8);
  for (int trial = 0; trial < 12; ++trial) {
    const test::RandomBench bench = test::random_bench(rng, 1);
    Instrument in = bench.instrument;
    in.rows = std::min(in.rows, 150 + 37 * trial);
    in.columns = std::min(in.columns, 70 + 53 * trial);
    in.calibration = calibration();
    in.calibration->covariance *= 1e-2;
    Grid<double> f(in.rows, in.columns);
    for (int r = 0; r < in.rows; ++r) {
      for (int c = 0; c < in.columns; ++c)
        f(r, c) = r % 17 == 3 && c % 13 == 5 ? std::nan("") : 3 + std::sin(0.2 * r) + std::cos(0.3 * c);
    }
    const auto u = pose_uncertainty(in, bench.pose(), f);
    const PoseSensitivities exact(in, bench.pose(), f);
    std::vector<double> changes(exact.count());
    double largest = 0, worst = 0;
    for (int r = 0; r < in.rows; ++r) {
      for (int c = 0; c < in.columns; ++c) {
        exact.at(r, c, changes);
        double sum = 0;
        for (const double v : changes) sum += v * v;
        ASSERT_EQ(std::isnan((*u)(r, c)), std::isnan(sum)) << r << "," << c;
        if (std::isnan(sum)) continue;
        largest = std::max(largest, std::sqrt(sum));
        worst = std::max(worst, std::abs((*u)(r, c) - std::sqrt(sum)));
      }
    }
    EXPECT_LE(worst, kPoseMaxError * largest) << trial;
    EXPECT_GT(largest, 0);
  }
}

// A detector that reaches below the sample's horizon, and one close by: the tiles there are exact.
TEST(PoseUncertainty, TilesAcrossTheHorizonAndCloseBy) {
  for (const auto& [arm_deg, distance_mm] : {std::pair{130.0, 325.0}, {80.0, 12.0}}) {
    Instrument in = test::instrument_of(bench());
    in.geometry.distance = distance_mm * 1e-3;
    in.calibration = calibration();
    const Pose pose{kStage_deg * kRadPerDeg, arm_deg * kRadPerDeg};
    Grid<double> f(in.rows, in.columns, 5.0);
    const auto angles = angle_map(in, pose);
    double worst = 0, good = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
      if (angles.mask[i] != 0) f[i] = std::nan("");
    }
    const auto u = pose_uncertainty(in, pose, f);
    const PoseSensitivities exact(in, pose, f);
    std::vector<double> changes(exact.count());
    for (int r = 0; r < in.rows; ++r) {
      for (int c = 0; c < in.columns; ++c) {
        if (std::isnan(f(r, c))) continue;
        exact.at(r, c, changes);
        double sum = 0;
        for (const double v : changes) sum += v * v;
        good += 1;
        worst = std::max(worst, std::abs((*u)(r, c) / std::sqrt(sum) - 1));
      }
    }
    EXPECT_GT(good, 100) << arm_deg;
    EXPECT_LE(worst, kPoseMaxError) << arm_deg;
  }
}

TEST(PoseUncertainty, MaskedNeighboursDoNotMakeItNan) {
  Instrument in = test::instrument_of(bench());
  in.calibration = calibration();
  Grid<double> f(101, 121, 10.0);
  f(50, 61) = std::nan("");
  const auto u = pose_uncertainty(in, {kStage_deg * kRadPerDeg, kArm_deg * kRadPerDeg}, f);
  EXPECT_GT((*u)(50, 60), 0);
  EXPECT_TRUE(std::isnan((*u)(50, 61)));
}

}  // namespace
}  // namespace scatmap
