// Angles against pyFAI's poses, against the simulator's own long double derivation over random benches, and by laws.
// Does not prove that the conventions are those of a real bench: only that three derivations agree on them.
#include "scatmap/angles/angle_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/frame_extent.h"
#include "scatmap/base/error.h"
#include "tests/support/random_instrument.h"

namespace scatmap {
namespace {

// Differences of angles in the sphere's own measure, so that phi counts for nothing at the pole.
struct AngleError {
  long double theta, across;
};

AngleError angle_error(long double theta, long double phi, long double theta_ref, long double phi_ref) {
  constexpr long double kPi = std::numbers::pi_v<long double>;
  return {std::abs(theta - theta_ref), std::abs(std::sin(theta_ref) * std::remainder(phi - phi_ref, 2 * kPi))};
}

TEST(AngleMap, PyfaiPoses) {
  std::ifstream file(SCATMAP_TEST_DATA "/pyfai_poses.csv");
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  int compared = 0, behind = 0;
  while (std::getline(file, line)) {
    std::istringstream text(line);
    std::string cell;
    std::getline(text, cell, ',');
    std::vector<long double> v;
    while (std::getline(text, cell, ',')) v.push_back(std::stold(cell));
    ASSERT_EQ(v.size(), 21u);
    // pyFAI's axis 1 (slow, i) is our x, its axis 2 (fast, j) our y, its axis 3 our z; its rotations 1 and 2 are
    // left-handed. Stage and arm at 0 and a beam along −z make sample, laboratory and arm axes one.
    Instrument in;
    in.columns = static_cast<int>(v[0]);
    in.rows = static_cast<int>(v[1]);
    Geometry<double>& g = in.geometry;
    g.pixel_column = static_cast<double>(v[2]);
    g.pixel_row = static_cast<double>(v[3]);
    g.rotation_pitch = -static_cast<double>(v[7]);
    g.rotation_yaw = -static_cast<double>(v[8]);
    g.rotation_roll = static_cast<double>(v[9]);
    const Matrix3<double> r = rotation_z(g.rotation_roll) * rotation_y(g.rotation_yaw) * rotation_x(g.rotation_pitch);
    const Vector3<double> centre =
        r * Vector3<double>(0.5 * in.columns * g.pixel_column - static_cast<double>(v[5]),
                            0.5 * in.rows * g.pixel_row - static_cast<double>(v[6]), static_cast<double>(v[4]));
    g.offset_x = centre.x();
    g.offset_y = centre.y();
    g.distance = centre.z();
    const PixelAngles a = pixel_angles(sample_view(in, {0, 0}), static_cast<double>(v[10]), static_cast<double>(v[11]));
    const long double tth = v[19], chi = v[20], solid_angle = v[18];
    if (tth >= std::numbers::pi_v<long double> / 2) {
      EXPECT_EQ(a.mask & kBelowHorizon, kBelowHorizon);
      EXPECT_TRUE(std::isnan(a.theta_s_rad));
      ++behind;
      continue;
    }
    const AngleError e = angle_error(a.theta_s_rad, a.phi_s_rad, tth, 1.5L * std::numbers::pi_v<long double> - chi);
    EXPECT_LE(e.theta, kAngleMaxError_rad) << line;
    EXPECT_LE(e.across, kAngleMaxError_rad) << line;
    EXPECT_LE(std::abs(a.solid_angle_sr / solid_angle - 1), kSolidAngleMaxError) << line;
    ++compared;
  }
  EXPECT_EQ(compared + behind, 192);
  EXPECT_GE(compared, 120);
}

TEST(AngleMap, LongDoubleDerivationOverRandomBenches) {
  std::mt19937_64 rng(20261122);
  long double worst_theta = 0, worst_across = 0, worst_omega = 0, worst_incidence = 0;
  int pixels = 0;
  for (int i = 0; i < 400; ++i) {
    const auto bench = test::random_bench(rng, i % 2 == 0 ? 1 : 8);
    const synth::TruthGeometry truth(bench.truth, bench.stage_deg, bench.arm_deg);
    if (!(truth.incidence_rad() < 89 * kRadPerDeg)) continue;
    const SampleView view = sample_view(bench.instrument, bench.pose());
    const double spread = frame_extent(view, bench.truth.rows, bench.truth.columns).spread;
    worst_incidence = std::max(worst_incidence, std::abs(truth.incidence_rad() - incidence_angle(view)));
    for (int k = 0; k < 50; ++k) {
      const int column = static_cast<int>(rng() % static_cast<unsigned>(bench.truth.columns)),
                row = static_cast<int>(rng() % static_cast<unsigned>(bench.truth.rows));
      const auto expected = truth.pixel(column, row);
      const PixelAngles a = pixel_angles(view, column, row);
      ASSERT_EQ(a.mask == 0, expected.has_value());
      if (!expected) continue;
      const AngleError e = angle_error(a.theta_s_rad, a.phi_s_rad, expected->theta_s_rad, expected->phi_s_rad);
      // At normal incidence phi has no zero; and rounding counts by the distance of the farthest pixel.
      const long double weight = std::sin(truth.incidence_rad()) / spread;
      worst_theta = std::max(worst_theta, e.theta * weight);
      worst_across = std::max(worst_across, e.across * weight);
      worst_omega = std::max(worst_omega, std::abs(a.solid_angle_sr / expected->solid_angle_sr - 1));
      ++pixels;
    }
  }
  EXPECT_GE(pixels, 10000);
  EXPECT_LE(worst_theta, kAngleMaxError_rad);
  EXPECT_LE(worst_across, kAngleMaxError_rad);
  EXPECT_LE(worst_omega, kSolidAngleMaxError);
  constexpr double kIncidence_rad = 2e-14;  // the spot's and the beam's rounding, up to 89 degrees
  EXPECT_LE(worst_incidence, kIncidence_rad);
  RecordProperty("worst_theta_rad", std::to_string(worst_theta * 1e16L) + "e-16");
  RecordProperty("worst_solid_angle", std::to_string(worst_omega * 1e16L) + "e-16");
}

// The sample's x axis is then the difference of two nearly equal vectors.
TEST(AngleMap, NearNormalIncidence) {
  for (const double stage_deg : {1e-10, 1e-9, 1e-7, 1e-4}) {
    synth::Bench b;
    b.columns = b.rows = 64;
    b.pitch_um = {200, 200};
    b.distance_mm = 325;
    const synth::TruthGeometry truth(b, stage_deg, 10);
    const SampleView view = sample_view(test::instrument_of(b), {stage_deg * kRadPerDeg, 10 * kRadPerDeg});
    for (const int row : {0, 20, 63}) {
      const auto expected = truth.pixel(7, row).value();
      const PixelAngles a = pixel_angles(view, 7, row);
      const AngleError e = angle_error(a.theta_s_rad, a.phi_s_rad, expected.theta_s_rad, expected.phi_s_rad);
      EXPECT_LE(e.theta, kAngleMaxError_rad) << stage_deg;
      EXPECT_LE(e.across, kAngleMaxError_rad) << stage_deg;
    }
  }
}

Instrument aligned() {
  Instrument in;
  in.columns = 101;
  in.rows = 81;
  in.geometry.pixel_column = 10e-6;
  in.geometry.pixel_row = 20e-6;
  in.geometry.distance = 0.325;
  return in;
}

constexpr double kTheta = 20 * kRadPerDeg;

TEST(AngleMap, SpecularIsAtTheCentreWithPhiPi) {
  const PixelAngles a = pixel_angles(sample_view(aligned(), {kTheta, 2 * kTheta}), 50, 40);
  EXPECT_NEAR(a.theta_s_rad, kTheta, 1e-15);
  EXPECT_NEAR(a.phi_s_rad, std::numbers::pi, 1e-15);
  EXPECT_NEAR(a.solid_angle_sr, 10e-6 * 20e-6 / (0.325 * 0.325), 1e-24);
}

TEST(AngleMap, ColumnsGrowTowardsLargerThetaAndRowsTowardsPlusY) {
  const SampleView view = sample_view(aligned(), {kTheta, 2 * kTheta});
  EXPECT_GT(pixel_angles(view, 51, 40).theta_s_rad, pixel_angles(view, 50, 40).theta_s_rad);
  EXPECT_GT(view.pixel(50, 41).y(), view.pixel(50, 40).y());
  // +y is past pi when phi is measured from −x towards −y.
  EXPECT_GT(pixel_angles(view, 50, 41).phi_s_rad, std::numbers::pi);
}

TEST(AngleMap, FlipsMirrorTheArray) {
  Instrument flipped = aligned();
  flipped.flip_columns = true;
  flipped.flip_rows = true;
  const SampleView a = sample_view(aligned(), {kTheta, 0.6}), b = sample_view(flipped, {kTheta, 0.6});
  EXPECT_LE((a.pixel(3, 7) - b.pixel(97, 73)).norm(), 1e-16);
  EXPECT_GT(pixel_angles(b, 3, 7).solid_angle_sr, 0);  // the sensitive side stays in front
}

TEST(AngleMap, HorizonAndBackOfTheDetectorAreMaskedNotNumbered) {
  // Stage 80°, arm at −30°: the detector is behind the sample's horizon.
  const PixelAngles below = pixel_angles(sample_view(aligned(), {80 * kRadPerDeg, -30 * kRadPerDeg}), 50, 40);
  EXPECT_EQ(below.mask, kBelowHorizon);
  Instrument turned = aligned();
  turned.geometry.rotation_yaw = std::numbers::pi;
  const PixelAngles behind = pixel_angles(sample_view(turned, {kTheta, 2 * kTheta}), 50, 40);
  EXPECT_EQ(behind.mask, kBehindDetector);
  for (const PixelAngles& a : {below, behind}) {
    EXPECT_TRUE(std::isnan(a.theta_s_rad) && std::isnan(a.phi_s_rad) && std::isnan(a.solid_angle_sr));
  }
}

TEST(AngleMap, ImpossiblePosesAreRefused) {
  EXPECT_THROW(sample_view(aligned(), {90 * kRadPerDeg, 0.5}), Error);
  EXPECT_THROW(sample_view(aligned(), {120 * kRadPerDeg, 0.5}), Error);
  Instrument edge_on = aligned();
  edge_on.geometry.rotation_yaw = std::numbers::pi / 2;
  EXPECT_THROW(sample_view(edge_on, {kTheta, 2 * kTheta}), Error);
}

TEST(AngleMap, TheMapIsItsPixels) {
  Instrument in = aligned();
  in.geometry.rotation_pitch = 0.01;
  const Pose pose{kTheta, 2 * kTheta};
  const AngleMap map = angle_map(in, pose);
  ASSERT_EQ(map.theta_s_rad.rows(), in.rows);
  ASSERT_EQ(map.theta_s_rad.columns(), in.columns);
  const PixelAngles a = pixel_angles(sample_view(in, pose), 17, 63);
  const double bound_rad = kVectorMaxError_rad + kExactMaxError_rad;  // the detector is small: one distance
  EXPECT_NEAR(map.theta_s_rad(63, 17), a.theta_s_rad, bound_rad);
  EXPECT_NEAR(std::sin(a.theta_s_rad) * (map.phi_s_rad(63, 17) - a.phi_s_rad), 0, bound_rad);
}

}  // namespace
}  // namespace scatmap
