#include "scatmap/angles/angle_map.h"

#include <cmath>
#include <limits>

#include "scatmap/base/parallel_rows.h"

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
  return angle_map(sample_view(instrument, pose), instrument.rows, instrument.columns);
}

}  // namespace scatmap
