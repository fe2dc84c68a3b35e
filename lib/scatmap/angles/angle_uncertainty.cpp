#include "scatmap/angles/angle_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scatmap/base/parallel.h"

namespace scatmap {
namespace {

struct Moments {
  double theta2 = 0, phi2 = 0, theta_phi = 0, pixel2 = 0;
};

Moments moments(const SampleView& view, const std::vector<ViewChange>& changes, int row, int column) {
  const Vector3<double> ray = view.pixel(column, row);
  const double r = ray.norm(), across = std::hypot(ray.x(), ray.y());
  const double cos_phi = across > 0 ? ray.x() / across : 1, sin_phi = across > 0 ? ray.y() / across : 0;
  const Vector3<double> along_theta(cos_phi * ray.z() / r, sin_phi * ray.z() / r, -across / r),
      along_phi(-sin_phi, cos_phi, 0);
  const Vector3<double> plane = view.column_step.cross(view.row_step);
  const double facing = plane.dot(ray);
  Moments m;
  for (const ViewChange& change : changes) {
    const Vector3<double> d_ray = change.of_pixel(column, row);
    const double d_theta = along_theta.dot(d_ray) / r;
    const double d_phi = across > 0 ? along_phi.dot(d_ray) / across : HUGE_VAL;
    // The detector point in the old direction: the ray's change less what runs along the ray, in steps of the pixels.
    const Vector3<double> shift = d_ray - ray * (plane.dot(d_ray) / facing);
    const double d_column = shift.cross(view.row_step).dot(plane) / plane.squaredNorm();
    const double d_row = view.column_step.cross(shift).dot(plane) / plane.squaredNorm();
    m.theta2 += d_theta * d_theta;
    m.phi2 += d_phi * d_phi;
    m.theta_phi += d_theta * d_phi;
    m.pixel2 += d_column * d_column + d_row * d_row;
  }
  return m;
}

}  // namespace

std::optional<AngleUncertainty> angle_uncertainty(const Instrument& instrument, const Pose& pose,
                                                  const Grid<Mask>& mask) {
  const std::vector<ViewChange> changes = calibration_changes(instrument, pose);
  if (changes.empty()) return std::nullopt;
  const SampleView view = sample_view(instrument, pose);
  const int rows = mask.rows(), columns = mask.columns();
  AngleUncertainty out{{rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}};
  constexpr double kUnknownAngle = std::numbers::pi / std::numbers::sqrt3;
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for_each_row(rows, [&](int row) {
    for (int c = 0; c < columns; ++c) {
      if (mask(row, c) != 0) {
        out.theta_s_rad(row, c) = out.phi_s_rad(row, c) = out.correlation(row, c) = out.direction_px(row, c) = kNaN;
        continue;
      }
      const Moments m = moments(view, changes, row, c);
      const double u_theta = std::sqrt(m.theta2), u_phi = std::sqrt(m.phi2), product = u_theta * u_phi;
      out.theta_s_rad(row, c) = static_cast<float>(u_theta);
      out.phi_s_rad(row, c) = static_cast<float>(std::min(u_phi, kUnknownAngle));
      out.correlation(row, c) = static_cast<float>(product > 0 && std::isfinite(product) ? m.theta_phi / product : 0);
      out.direction_px(row, c) = static_cast<float>(std::sqrt(m.pixel2));
    }
  });
  return out;
}

std::optional<double> smallest_direction_sigma_px(const Instrument& instrument, const Pose& pose) {
  const std::vector<ViewChange> changes = calibration_changes(instrument, pose);
  if (changes.empty()) return std::nullopt;
  const SampleView view = sample_view(instrument, pose);
  const int last_row = instrument.rows - 1, last_column = instrument.columns - 1;
  double smallest = HUGE_VAL;
  for (const int row : {0, last_row / 2, last_row}) {
    for (const int column : {0, last_column / 2, last_column})
      smallest = std::min(smallest, std::sqrt(moments(view, changes, row, column).pixel2));
  }
  return smallest;
}

}  // namespace scatmap
