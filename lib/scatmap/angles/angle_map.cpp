#include "scatmap/angles/angle_map.h"

#include <cmath>
#include <limits>

#include "scatmap/angles/angle_method.h"
#include "scatmap/angles/lens.h"
#include "scatmap/base/parallel.h"

namespace scatmap {

PixelAngles pixel_angles(const SampleView& view, double column, double row) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const Vector3<double> ray = view.pixel(column, row);
  const double facing = view.detector_normal.dot(ray);
  Mask mask = 0;
  if (!(ray.z() > 0)) mask |= kBelowHorizon;
  if (!(facing > 0)) mask |= kBehindDetector;
  if (mask != 0) return {kNaN, kNaN, kNaN, mask};
  const double r2 = ray.squaredNorm();
  return {polar_angle(ray), azimuth_from_minus_x(ray), view.pixel_area_m2 * facing / (r2 * std::sqrt(r2)), mask};
}

AngleMap angle_map(const SampleView& view, int rows, int columns) {
  AngleMap map{incidence_angle(view), {rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}};
  for_each_row(rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      const PixelAngles a = pixel_angles(view, column, row);
      map.theta_s_rad(row, column) = a.theta_s_rad;
      map.phi_s_rad(row, column) = a.phi_s_rad;
      map.solid_angle_sr(row, column) = a.solid_angle_sr;
      map.mask(row, column) = a.mask;
    }
  });
  return map;
}

AngleMap angle_map(const Instrument& instrument, const Pose& pose) {
  const SampleView view = sample_view(instrument, pose);
  if (instrument.lens_cameramodel)
    return angle_map(view, load_lens_rays(*instrument.lens_cameramodel, instrument.columns, instrument.rows));
  const int rows = instrument.rows, columns = instrument.columns;
  AngleMap map{0, {rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}};
  write_angle_map(view, with_method(AngleMethod::kVector, view, rows, columns, 0), map);
  return map;
}

Vector3<double> interpolated_direction(const AngleMap& map, PixelPosition at) {
  const int rows = map.mask.rows(), columns = map.mask.columns();
  const bool inside = at.column >= 0 && at.row >= 0 && at.column <= columns - 1 && at.row <= rows - 1;
  if (!inside) return Vector3<double>::Constant(std::numeric_limits<double>::quiet_NaN());
  const int column = static_cast<int>(at.column), row = static_cast<int>(at.row);
  const double x = at.column - column, y = at.row - row;
  Vector3<double> sum = Vector3<double>::Zero();
  for (int i = 0; i < 4; ++i) {
    const int dc = i % 2, dr = i / 2;
    const double share = (dc == 1 ? x : 1 - x) * (dr == 1 ? y : 1 - y);
    if (share == 0) continue;
    sum += share *
           direction_from_angles<double>(map.theta_s_rad(row + dr, column + dc), map.phi_s_rad(row + dr, column + dc));
  }
  return sum.normalized();
}

}  // namespace scatmap
