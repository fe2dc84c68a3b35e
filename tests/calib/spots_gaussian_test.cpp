// The pixel-integrated Gaussian against its own definition by other means (error functions and Simpson's rule), and its
// derivatives against differences. Does not prove anything about fits.
#include "calib/spots_gaussian.h"

#include <gtest/gtest.h>

#include "spot_frame.h"

namespace scatmap::calib {
namespace {

Eigen::Matrix2d covariance(double major, double minor, double angle) {
  Eigen::Matrix2d turn;
  turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return turn * Eigen::Vector2d(major * major, minor * minor).asDiagonal() * turn.transpose();
}

TEST(PixelGaussian, EqualsIndependentPixelIntegral) {
  for (const double width : {0.4, 0.5, 0.69, 0.71, 0.99, 1.01, 2.4, 2.6, 5.0}) {
    for (const double angle : {0.0, 0.4, 1.2, -0.9}) {
      const test::TrueSpot truth{10.23, 9.61, 1000, 1.4 * width, width, angle};
      const PixelGaussian gaussian(
          gaussian_spot(truth.column_px, truth.row_px, truth.flux_e, covariance(1.4 * width, width, angle)));
      double largest = 0, error = 0;
      for (int r = 0; r < 20; ++r) {
        for (int c = 0; c < 20; ++c) {
          const double expected = truth.flux_e * test::share_on_pixel(truth, c, r);
          largest = std::max(largest, expected);
          error = std::max(error, std::abs(gaussian.at(c, r).value_e - expected));
        }
      }
      EXPECT_LE(error, 3e-5 * largest) << "width " << width << ", angle " << angle;
    }
  }
}

TEST(PixelGaussian, GradientsEqualDifferences) {
  const GaussianSpot spot{5.2, 4.9, 700, 1.1, 0.4, 0.8};
  const auto moved = [&](int parameter, double by) {
    GaussianSpot s = spot;
    if (parameter == kColumn) s.column_px += by;
    if (parameter == kRow) s.row_px += by;
    if (parameter == kLogFlux) s.flux_e *= std::exp(by);
    if (parameter == kLogColumnSd) s.column_sd_px *= std::exp(by);
    if (parameter == kShear) s.shear_px += by;
    if (parameter == kLogRowSd) s.row_sd_px *= std::exp(by);
    return PixelGaussian(s);
  };
  constexpr double kStep = 1e-5;
  const PixelGaussian gaussian(spot);
  for (int p = 0; p < kSpotParameters; ++p) {
    const PixelGaussian up = moved(p, kStep), down = moved(p, -kStep);
    for (int r = 2; r < 9; ++r) {
      for (int c = 2; c < 9; ++c) {
        const double difference = (up.at(c, r).value_e - down.at(c, r).value_e) / (2 * kStep);
        EXPECT_NEAR(gaussian.at(c, r).gradient[static_cast<std::size_t>(p)], difference, 1e-6) << "parameter " << p;
      }
    }
  }
}

TEST(SpotAxes, GivesBackWidthsAndAngle) {
  for (const double angle : {-1.5, -0.7, 0.0, 0.3, 1.5}) {
    const SpotAxes axes = spot_axes(gaussian_spot(0, 0, 1, covariance(3, 1, angle)));
    EXPECT_NEAR(axes.major_px, 3, 1e-12);
    EXPECT_NEAR(axes.minor_px, 1, 1e-12);
    EXPECT_NEAR(axes.angle_rad, angle, 1e-12);
  }
}

}  // namespace
}  // namespace scatmap::calib
