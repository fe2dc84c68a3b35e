// Laws of directions and rotations, and the traps: accuracy at the pole, at the seam and between nearby directions.
#include "scatmap/base/direction.h"

#include <gtest/gtest.h>

#include <random>

#include "scatmap/base/rotation.h"

namespace scatmap {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Direction, AnglesAndBack) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 10000; ++i) {
    const double theta = std::uniform_real_distribution<double>(0, kPi)(rng),
                 phi = std::uniform_real_distribution<double>(0, 2 * kPi)(rng);
    const Vector3<double> v = direction_from_angles(theta, phi) * 3.5;
    EXPECT_LE(std::abs(polar_angle(v) - theta), 1e-15 * 8);
    EXPECT_LE(std::abs(std::remainder(azimuth_from_minus_x(v) - phi, 2 * kPi)) * std::sin(theta), 2e-15);
  }
}

TEST(Direction, AzimuthIsFromMinusXAndTheSeamIsBackScatter) {
  EXPECT_EQ(azimuth_from_minus_x(Vector3<double>(1, 0, 0.5)), kPi);  // forward: specular side
  EXPECT_EQ(azimuth_from_minus_x(Vector3<double>(-1, 0, 0.5)), 0);   // towards the source
  EXPECT_EQ(azimuth_from_minus_x(Vector3<double>(-1, -0.0, 0.5)), 0);
  EXPECT_EQ(azimuth_from_minus_x(Vector3<double>(0, -1, 0)), kPi / 2);  // from −x towards −y
  for (const double y : {1e-300, -1e-300, 1e-17, -1e-17}) {
    const double phi = azimuth_from_minus_x(Vector3<double>(-1, y, 0));
    EXPECT_GE(phi, 0);
    EXPECT_LT(phi, 2 * kPi);
  }
}

TEST(Direction, SmallAnglesKeepTheirDigits) {
  for (const double angle : {1e-12, 2e-4, 1e-3, 0.5, kPi - 1e-9}) {
    const Vector3<double> v(std::sin(angle), 0, std::cos(angle));
    EXPECT_LE(std::abs(polar_angle(v) / angle - 1), 1e-15);
    EXPECT_LE(std::abs(angle_between<double>(v, Vector3<double>(0, 0, 2)) - angle),
              2e-16 * std::max(1.0, angle) + 2e-16 * angle);
  }
  EXPECT_LE(std::abs(tan2_polar(Vector3<double>(2e-4, 0, 1)) / 4e-8 - 1), 1e-15);
  const Vector3<float> f(2e-4f, 0, 1);
  EXPECT_LE(std::abs(polar_angle(f) / 2e-4f - 1), 3e-7f);  // acosf(cosf(2e-4)) would be 0
}

TEST(Direction, NanInNanOut) {
  const Vector3<double> v(std::nan(""), 0, 1);
  EXPECT_TRUE(std::isnan(polar_angle(v)));
  EXPECT_TRUE(std::isnan(azimuth_from_minus_x(v)));
  EXPECT_TRUE(std::isnan(half_vector<double>(Vector3<double>(0, 0, 1), Vector3<double>(0, 0, -1)).x()));
}

TEST(Rotation, ActiveAndRightHanded) {
  const double a = 0.3;
  const Vector3<double> x(1, 0, 0), z(0, 0, 1);
  EXPECT_LE((rotation_y(a) * z - Vector3<double>(std::sin(a), 0, std::cos(a))).norm(), 1e-16);
  EXPECT_LE((rotation_x(a) * z - Vector3<double>(0, -std::sin(a), std::cos(a))).norm(), 1e-16);
  EXPECT_LE((rotation_z(a) * x - Vector3<double>(std::cos(a), std::sin(a), 0)).norm(), 1e-16);
  const Matrix3<double> r = rotation_x(0.1) * rotation_y(0.2) * rotation_z(0.3);
  EXPECT_LE((r * r.transpose() - Matrix3<double>::Identity()).norm(), 1e-15);
  EXPECT_NEAR(r.determinant(), 1, 1e-15);
}

}  // namespace
}  // namespace scatmap
