#pragma once
#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "scatmap/counts/sensor_model.h"

/// Simulated camera frames of Gaussian spots, made without calib: the pixel integral is an error function along the
/// rows' direction and Simpson's rule along the columns'.
namespace scatmap::test {

struct TrueSpot {
  double column_px = 0;
  double row_px = 0;
  double flux_e = 0;
  double major_px = 2;
  double minor_px = 2;
  double angle_rad = 0;
};

struct TrueCamera {
  int columns = 64;
  int rows = 64;
  double gain_e_per_dn = 1.5;
  double read_noise_e = 8;
  double bias_dn = 300;
  double background_e = 0;  ///< light, with shot noise
  double saturation_dn = 1e7;

  SensorModel sensor() const { return {gain_e_per_dn, read_noise_e, saturation_dn, bias_dn, {}}; }
  /// Variance of a pixel without light, e².
  double floor_e2() const { return read_noise_e * read_noise_e + gain_e_per_dn * gain_e_per_dn / 12; }
};

/// Share of a spot's light on one pixel.
inline double share_on_pixel(const TrueSpot& s, int column, int row) {
  const double c = std::cos(s.angle_rad), sn = std::sin(s.angle_rad);
  const double a2 = s.major_px * s.major_px, b2 = s.minor_px * s.minor_px;
  const double xx = a2 * c * c + b2 * sn * sn, xy = (a2 - b2) * c * sn, yy = a2 * sn * sn + b2 * c * c;
  const double conditional = std::sqrt(yy - xy * xy / xx);
  constexpr int kSteps = 16;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = column - 0.5 + static_cast<double>(i) / kSteps - s.column_px;
    const double weight = (i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2) / (3.0 * kSteps);
    const double centre = s.row_px + xy / xx * x;
    const auto below = [&](double edge) {
      return 0.5 * std::erfc(-(edge - centre) / (conditional * std::numbers::sqrt2));
    };
    sum += weight * std::exp(-0.5 * x * x / xx) / std::sqrt(2 * std::numbers::pi * xx) *
           (below(row + 0.5) - below(row - 0.5));
  }
  return sum;
}

/// Expected electrons, row after row.
inline std::vector<double> expected_e(const TrueCamera& camera, const std::vector<TrueSpot>& spots) {
  std::vector<double> out;
  for (int r = 0; r < camera.rows; ++r) {
    for (int c = 0; c < camera.columns; ++c) {
      double e = camera.background_e;
      for (const TrueSpot& s : spots) {
        if (std::hypot(c - s.column_px, r - s.row_px) < 9 * s.major_px + 2) e += s.flux_e * share_on_pixel(s, c, r);
      }
      out.push_back(e);
    }
  }
  return out;
}

/// Poisson light, normal read noise, rounding to whole counts, clipping at saturation.
inline Frame camera_frame(const TrueCamera& camera, const std::vector<double>& light_e, std::mt19937_64& random) {
  Frame f{Grid<float>(camera.rows, camera.columns), 1, "simulated", {}};
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < light_e.size(); ++i) {
    const double e = light_e[i] > 0 ? static_cast<double>(std::poisson_distribution<long long>(light_e[i])(random)) : 0;
    const double dn = std::round(camera.bias_dn + (e + camera.read_noise_e * normal(random)) / camera.gain_e_per_dn);
    f.dn[i] = static_cast<float>(std::min(dn, std::floor(camera.saturation_dn)));
  }
  return f;
}

/// Cramér-Rao bound on the covariance of (column, row) of the first spot when its flux, covariance and the background
/// are unknown too, by central differences of the expectation.
inline Eigen::Matrix2d cramer_rao_px2(const TrueCamera& camera, const TrueSpot& spot) {
  const auto moved = [&](int parameter, double by) {
    TrueSpot s = spot;
    TrueCamera c = camera;
    double* const numbers[] = {&s.column_px, &s.row_px,    &s.flux_e,      &s.major_px,
                               &s.minor_px,  &s.angle_rad, &c.background_e};
    *numbers[parameter] += by;
    return expected_e(c, {s});
  };
  // The angle of a round spot has no effect; then the two axes and the angle stand for two parameters.
  const bool round = std::abs(spot.major_px - spot.minor_px) < 1e-9;
  std::vector<int> free{0, 1, 2, 3, 4, 6};
  if (!round) free.push_back(5);
  const std::vector<double> e = expected_e(camera, {spot});
  Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(e.size()), static_cast<Eigen::Index>(free.size()));
  for (std::size_t k = 0; k < free.size(); ++k) {
    const double h = free[k] == 2 ? 1e-3 * spot.flux_e : 1e-3;
    const auto up = moved(free[k], h), down = moved(free[k], -h);
    for (std::size_t i = 0; i < e.size(); ++i) {
      jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          (up[i] - down[i]) / (2 * h) / std::sqrt(e[i] + camera.floor_e2());
    }
  }
  return (jacobian.transpose() * jacobian).inverse().topLeftCorner<2, 2>();
}

}  // namespace scatmap::test
