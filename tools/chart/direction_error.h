#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "scatmap/angles/pixel_plane.h"
#include "tools/chart/chart.h"
#include "tools/chart/error_sample.h"

namespace scatmap::tools {

inline std::string size_text(const Instrument& in) {
  return std::to_string(in.columns) + " x " + std::to_string(in.rows);
}

/// Distance on the sphere, rad: theta, and phi as far as it moves the direction.
inline double direction_error(long double theta, long double phi, long double true_theta, long double true_phi) {
  constexpr long double kPi = std::numbers::pi_v<long double>;
  const long double across = std::sin(true_theta) * std::remainder(phi - true_phi, 2 * kPi);
  return static_cast<double>(std::hypot(theta - true_theta, across));
}

/// Smallest change of direction, rad, from this pixel to the next along any line.
inline double pixel_step_rad(const SampleView& view, int column, int row) {
  const Vector3<double> ray = view.pixel(column, row);
  return std::min(view.column_step.norm(), view.row_step.norm()) * std::abs(view.detector_normal.dot(ray)) /
         ray.squaredNorm();
}

/// Errors of directions in both units.
struct DirectionErrors {
  ErrorSample rad, px;
  void add(double error_rad, double step_rad, int column, int row) {
    rad.add(error_rad, column, row);
    px.add(error_rad / step_rad, column, row);
  }
  void into(ChartRow& out) const {
    out.largest_error = px.largest();
    out.p99_error = px.percentile(99);
    out.largest_error_rad = rad.largest();
    out.worst_at = px.worst_at();
  }
};

}  // namespace scatmap::tools
