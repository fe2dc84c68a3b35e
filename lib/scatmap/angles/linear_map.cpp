#include "scatmap/angles/linear_map.h"

#include <algorithm>
#include <cmath>

#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/frame_extent.h"
#include "scatmap/angles/linear_kernel.h"
#include "scatmap/angles/taylor_bound.h"
#include "scatmap/base/parallel.h"

namespace scatmap {

// Change of the angles per step at the middle.
LinearMap::Step LinearMap::step(const WideRay& p, const Vector3<double>& step) {
  const Wide rho2 = p.x * p.x + p.y * p.y, rho = std::sqrt(rho2), along = p.x * step.x() + p.y * step.y();
  return {static_cast<double>((along * p.z / rho - rho * step.z()) / (rho2 + p.z * p.z)),
          static_cast<double>((p.x * step.y() - p.y * step.x()) / rho2)};
}

LinearMap::LinearMap(const SampleView& view, int rows, int columns)
    : view_(view), columns_(columns), middle_row_(0.5 * (rows - 1)), middle_column_(0.5 * (columns - 1)) {
  const Vector3<double> middle = view.pixel(middle_column_, middle_row_);
  theta_ = polar_angle<double>(middle);
  phi_ = azimuth_from_minus_x<double>(middle);
  const WideRay wide = reference_ray(view, middle_column_, middle_row_);
  along_ = step(wide, view.column_step);
  down_ = step(wide, view.row_step);
}

void LinearMap::row(int row, std::span<float> theta_s_rad, std::span<float> phi_s_rad) const {
  const double e = row - middle_row_, theta = theta_ + e * down_.theta, phi = phi_ + e * down_.phi;
  kernel::LinearRow line{static_cast<float>(-middle_column_), {}, {}, {}, {}, {}, {}};
  line.theta = static_cast<float>(theta);
  line.theta_rest = static_cast<float>(theta - static_cast<double>(line.theta));
  line.theta_step = static_cast<float>(along_.theta);
  line.phi = static_cast<float>(phi);
  line.phi_rest = static_cast<float>(phi - static_cast<double>(line.phi));
  line.phi_step = static_cast<float>(along_.phi);
  kernel::run_linear(line, static_cast<std::size_t>(columns_), theta_s_rad.data(), phi_s_rad.data());
  const ColumnRange visible = visible_columns(view_, row, {0, columns_});
  for (const std::span<float> out : {theta_s_rad, phi_s_rad}) {
    std::fill(out.begin(), out.begin() + visible.first, NAN);
    std::fill(out.begin() + visible.last, out.end(), NAN);
  }
}

void write_linear_map(const SampleView& view, AngleMapOf<float>& map) {
  const int rows = map.theta_s_rad.rows(), columns = map.theta_s_rad.columns();
  map.theta_i_rad = incidence_angle(view);
  const LinearMap linear(view, rows, columns);
  for_each_row(rows, [&](int r) {
    linear.row(r, map.theta_s_rad.row(r), map.phi_s_rad.row(r));
    AngleRow<float> rest;
    if (!map.solid_angle_sr.empty()) rest.solid_angle_sr = map.solid_angle_sr.row(r);
    if (!map.mask.empty()) rest.mask = map.mask.row(r);
    angle_row(view, r, {0, columns}, rest);
  });
}

double linear_bound_rad(const SampleView& view, int rows, int columns) {
  const double x = 0.5 * (columns - 1), y = 0.5 * (rows - 1);
  const Vector3<double> middle = view.pixel(x, y);
  double worst = 0;
  for (const double sign : {-1.0, 1.0}) {
    const Vector3<double> corner = x * view.column_step + sign * y * view.row_step;
    const double rho = std::hypot(middle.x(), middle.y()), r = middle.norm();
    worst = std::max(worst,
                     taylor_remainder_rad({rho, rho, r, r, std::hypot(corner.x(), corner.y()), corner.norm()}, 1, 1));
  }
  // A bound towards every edge point follows from those towards the corners only where lengths grow along the edge:
  // lengths of differences are convex, so they do.
  return worst + linear_rounding_rad(frame_extent(view, rows, columns));
}

}  // namespace scatmap
