// The truth's geometry against cases worked out by hand, one parameter at a time, and one solid angle in closed form.
// Does not prove the product of several rotations (tests that compare the library with this truth and with pyFAI do).
#include "data-synthetic/truth_geometry.h"

#include <gtest/gtest.h>

#include <cmath>

namespace scatmap::synth {
namespace {

constexpr double kR_mm = 325;
constexpr double kPitch_um = 10;

Bench plain_bench() {
  Bench b;
  b.columns = 1001;
  b.rows = 801;
  b.pitch_um = {kPitch_um, kPitch_um};
  b.distance_mm = kR_mm;
  return b;
}

double radians(double deg) { return deg * std::acos(-1.0) / 180; }
double pixels(double mm) { return mm * 1000 / kPitch_um; }
double d(long double v) { return static_cast<double>(v); }

void expect_at(const std::optional<PixelPoint>& point, double column_px, double row_px) {
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(d(point->column_px), column_px, 1e-9);
  EXPECT_NEAR(d(point->row_px), row_px, 1e-9);
}

TEST(TruthGeometry, SpecularPixelLiesOnTheBoresight) {
  for (const double theta_i_deg : {10.0, 20.0, 45.0, 60.0, 80.0}) {
    const TruthGeometry g(plain_bench(), theta_i_deg, 2 * theta_i_deg);
    const auto centre = g.pixel(500, 400);
    ASSERT_TRUE(centre.has_value());
    EXPECT_NEAR(d(g.incidence_rad()), radians(theta_i_deg), 1e-15);
    EXPECT_NEAR(d(centre->theta_s_rad), radians(theta_i_deg), 1e-15);
    EXPECT_NEAR(d(centre->phi_s_rad), radians(180), 1e-15);
    expect_at(g.mirror_hit(), 500, 400);
  }
}

TEST(TruthGeometry, SourceLiesAtMinusX) {
  const Vec3 b = TruthGeometry(plain_bench(), 20, 40).to_source();
  EXPECT_NEAR(d(b.x), -std::sin(radians(20)), 1e-16);
  EXPECT_NEAR(d(b.y), 0, 1e-16);
  EXPECT_NEAR(d(b.z), std::cos(radians(20)), 1e-16);
}

TEST(TruthGeometry, ColumnsGrowWithTheArmAngle) {
  const TruthGeometry g(plain_bench(), 20, 40);
  const auto right = g.pixel(900, 400);
  ASSERT_TRUE(right.has_value());
  EXPECT_NEAR(d(right->theta_s_rad), radians(20) + std::atan(4.0 / kR_mm), 1e-15);
}

TEST(TruthGeometry, RowsGrowWithY) {
  const TruthGeometry g(plain_bench(), 20, 40);
  EXPECT_NEAR(d(g.pixel_m(500, 700).y), 3e-3, 1e-15);
  const auto low = g.pixel(500, 700);
  ASSERT_TRUE(low.has_value());
  // In sample axes the pixel is R·(sin 20°, 0, cos 20°) + 3 mm·y; forward and +y is between π and 3π/2.
  EXPECT_NEAR(d(low->phi_s_rad), radians(180) + std::atan2(3, kR_mm * std::sin(radians(20))), 1e-15);
}

TEST(TruthGeometry, FlipsMirrorAboutTheMiddle) {
  Bench b = plain_bench();
  b.flip_columns = true;
  const TruthGeometry plain(plain_bench(), 20, 40), flipped(b, 20, 40);
  EXPECT_NEAR(d(length(flipped.pixel_m(100, 300) - plain.pixel_m(900, 300))), 0, 1e-17);
  b.flip_rows = true;
  const TruthGeometry both(b, 20, 40);
  EXPECT_NEAR(d(length(both.pixel_m(100, 300) - plain.pixel_m(900, 500))), 0, 1e-17);
  EXPECT_GT(d(both.pixel(0, 0)->solid_angle_sr), 0);
}

TEST(TruthGeometry, SolidAngleOfThePixelsIsThatOfTheRectangle) {
  const TruthGeometry g(plain_bench(), 20, 40);
  long double sum = 0;
  for (int r = 0; r < 801; ++r) {
    for (int c = 0; c < 1001; ++c) sum += g.pixel(c, r)->solid_angle_sr;
  }
  const double a = 10.01, b = 8.01, z = kR_mm;
  const double whole_sr = 4 * std::atan(a * b / (2 * z * std::sqrt(4 * z * z + a * a + b * b)));
  // The midpoint rule's relative error is of order (pitch/R)² = 1e-9.
  EXPECT_NEAR(d(sum) / whole_sr, 1, 1e-9);
}

TEST(TruthGeometry, TiltedMirrorByHand) {
  // n = Ry(45°)·Rx(τ)·z reflects −z into (cos²τ, −√2 sinτ cosτ, −sin²τ); the sensor is the plane x = R.
  const double tau = radians(0.4);
  const TruthGeometry g(plain_bench(), 45, 90, 0.4);
  const double tan = std::tan(tau);
  expect_at(g.mirror_hit(), 500 + pixels(kR_mm * tan * tan), 400 - pixels(kR_mm * std::sqrt(2.0) * tan));
  Bench b = plain_bench();
  b.sample_tilt_deg = 0.4;
  expect_at(TruthGeometry(b, 45, 90).mirror_hit(), 500 + pixels(kR_mm * tan * tan),
            400 - pixels(kR_mm * std::sqrt(2.0) * tan));
}

TEST(TruthGeometry, MirrorHeightShiftsTheBeam) {
  Bench b = plain_bench();
  b.sample_height_mm = 0.3;
  const TruthGeometry g(b, 45, 90);
  // The spot moves to z = h√2; at arm 90° columns run towards −z.
  EXPECT_NEAR(d(g.spot_m().z), 0.3e-3 * std::sqrt(2.0), 1e-17);
  expect_at(g.mirror_hit(), 500 - pixels(0.3 * std::sqrt(2.0)), 400);
}

TEST(TruthGeometry, ZerosAddToTheCommandedAngles) {
  Bench b = plain_bench();
  b.stage_zero_deg = 0.25;
  b.arm_zero_deg = -0.125;
  const TruthGeometry shifted(b, 20, 40), commanded(plain_bench(), 20.25, 39.875);
  EXPECT_EQ(shifted.pixel(100, 200)->theta_s_rad, commanded.pixel(100, 200)->theta_s_rad);
  EXPECT_NEAR(d(shifted.incidence_rad()), radians(20.25), 1e-15);
}

TEST(TruthGeometry, DirectBeamByHand) {
  // At arm 180° columns run towards −x and rows towards +y; the sensor is the plane z = −R.
  expect_at(TruthGeometry(plain_bench(), 20, 180).direct_hit(), 500, 400);
  Bench offset = plain_bench();
  offset.beam_offset_mm = {0.5, 0.25};
  expect_at(TruthGeometry(offset, 20, 180).direct_hit(), 500 - 50, 400 + 25);
  Bench elevated = plain_bench();
  elevated.beam_elevation_deg = 0.1;
  expect_at(TruthGeometry(elevated, 20, 180).direct_hit(), 500, 400 - pixels(kR_mm * std::tan(radians(0.1))));
  Bench axis = plain_bench();
  axis.axis_offset_mm = {0.5, 3};
  expect_at(TruthGeometry(axis, 20, 180).direct_hit(), 500 + 50, 400);
  Bench leaning = plain_bench();
  leaning.axis_tilt_deg = {0.2, 0};
  expect_at(TruthGeometry(leaning, 20, 180).direct_hit(), 500, 400 - pixels(kR_mm * std::tan(radians(0.2))));
  Bench aside = plain_bench();
  aside.offset_mm = {0.5, -0.25};
  expect_at(TruthGeometry(aside, 20, 180).direct_hit(), 500 - 50, 400 + 25);
  EXPECT_FALSE(TruthGeometry(plain_bench(), 20, 0).direct_hit().has_value());
}

TEST(TruthGeometry, AxisTiltAboutZTurnsTheArmPlane) {
  // Rz(90°) of the arm at 90°, (1, 0, 0), is (0, 1, 0): the sensor goes overhead.
  Bench b = plain_bench();
  b.axis_tilt_deg = {0, 90};
  const Vec3 centre_m = TruthGeometry(b, 20, 90).pixel_m(500, 400);
  EXPECT_NEAR(d(length(centre_m - Vec3{0, 0.325L, 0})), 0, 1e-16);
}

TEST(TruthGeometry, DetectorRotationByHand) {
  Bench rolled = plain_bench();
  rolled.rotation_deg = {0, 0, 90};
  rolled.beam_offset_mm = {0, 0.25};
  // Rz(90°) carries the column axis onto +y.
  expect_at(TruthGeometry(rolled, 20, 180).direct_hit(), 500 + 25, 400);
  Bench yawed = plain_bench();
  yawed.rotation_deg = {0, 30, 0};
  const TruthGeometry yaw(yawed, 20, 40);
  EXPECT_NEAR(d(yaw.pixel(500, 400)->solid_angle_sr) / (1e-10 / (0.325 * 0.325)), std::cos(radians(30)), 1e-14);
  EXPECT_NEAR(d(length(yaw.pixel_m(900, 400))), std::hypot(0.325 - 4e-3 * 0.5, 4e-3 * std::cos(radians(30))), 1e-16);
  Bench pitched = plain_bench();
  pitched.rotation_deg = {30, 0, 0};
  const TruthGeometry pitch(pitched, 20, 40);
  EXPECT_NEAR(d(length(pitch.pixel_m(500, 700))), std::hypot(0.325 + 3e-3 * 0.5, 3e-3 * std::cos(radians(30))), 1e-16);
}

TEST(TruthGeometry, RotationsTurnInTheirOrder) {
  // Rx(90°)·Rz(90°) carries the arm's x onto y, then z.
  Bench axes = plain_bench();
  axes.axis_tilt_deg = {90, 90};
  EXPECT_NEAR(d(length(TruthGeometry(axes, 20, 90).pixel_m(500, 400) - Vec3{0, 0, 0.325L})), 0, 1e-16);
  // Rz(90°)·Ry(90°)·Rx(90°) carries the column axis x onto x, −z, −z and the row axis y onto z, x, y.
  Bench sensor = plain_bench();
  sensor.rotation_deg = {90, 90, 90};
  EXPECT_NEAR(d(length(TruthGeometry(sensor, 20, 0).pixel_m(900, 700) - Vec3{0, 3e-3L, 0.321L})), 0, 1e-16);
}

TEST(TruthGeometry, NothingIsSeenBelowTheHorizonFromBehindOrUnlit) {
  EXPECT_FALSE(TruthGeometry(plain_bench(), 20, 120).pixel(500, 400).has_value());
  EXPECT_TRUE(TruthGeometry(plain_bench(), 20, 100).pixel(500, 400).has_value());
  Bench turned = plain_bench();
  turned.rotation_deg = {0, 180, 0};
  EXPECT_FALSE(TruthGeometry(turned, 20, 40).pixel(500, 400).has_value());
  EXPECT_FALSE(TruthGeometry(plain_bench(), 120, 100).pixel(500, 400).has_value());
  EXPECT_FALSE(TruthGeometry(plain_bench(), 120, 240).mirror_hit().has_value());
}

TEST(TruthGeometry, SeamOfPhiLiesAtBackScatter) {
  // Arm 0: the sensor looks at the source, so its middle sees exactly back along the beam.
  const TruthGeometry g(plain_bench(), 20, 0);
  EXPECT_NEAR(d(g.pixel(500, 400)->theta_s_rad), radians(20), 1e-15);
  EXPECT_LE(d(g.pixel(500, 401)->phi_s_rad), radians(360));
  EXPECT_GE(d(g.pixel(500, 399)->phi_s_rad), 0);
  EXPECT_GT(std::fabs(d(g.pixel(500, 401)->phi_s_rad - g.pixel(500, 399)->phi_s_rad)), 6);
}

TEST(TruthGeometry, NormalIncidenceFallsBackToTheStageAxis) {
  const TruthGeometry g(plain_bench(), 0, 10);
  EXPECT_EQ(d(g.incidence_rad()), 0);
  EXPECT_NEAR(d(g.pixel(500, 400)->phi_s_rad), radians(180), 1e-15);
  EXPECT_NEAR(d(g.pixel(500, 400)->theta_s_rad), radians(10), 1e-15);
}

}  // namespace
}  // namespace scatmap::synth
