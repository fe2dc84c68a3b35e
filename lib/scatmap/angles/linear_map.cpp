#include "scatmap/angles/linear_map.h"

#include <algorithm>
#include <cmath>

#include "scatmap/angles/angle_line.h"
#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/frame_extent.h"
#include "scatmap/angles/linear_kernel.h"
#include "scatmap/angles/taylor_bound.h"
#include "scatmap/base/parallel.h"

namespace scatmap {
namespace {

struct Gradient {
  double theta, phi;
};

// Change of the angles per `step` at the ray p.
Gradient gradient(const WideRay& p, const Vector3<double>& step) {
  const Wide rho2 = p.x * p.x + p.y * p.y, rho = std::sqrt(rho2), along = p.x * step.x() + p.y * step.y();
  return {static_cast<double>((along * p.z / rho - rho * step.z()) / (rho2 + p.z * p.z)),
          static_cast<double>((p.x * step.y() - p.y * step.x()) / rho2)};
}

}  // namespace

void write_linear_map(const SampleView& view, AngleMapOf<float>& map) {
  const int rows = map.theta_s_rad.rows(), columns = map.theta_s_rad.columns();
  map.theta_i_rad = incidence_angle(view);
  const double middle_row = 0.5 * (rows - 1), middle_column = 0.5 * (columns - 1);
  const WideRay middle = wide_ray(view, middle_column, middle_row);
  const double theta = polar_angle<double>(view.pixel(middle_column, middle_row)),
               phi = azimuth_from_minus_x<double>(view.pixel(middle_column, middle_row));
  const Gradient along = gradient(middle, view.column_step), down = gradient(middle, view.row_step);
  const auto columns_wide = static_cast<std::size_t>(columns);
  for_each_row(rows, [&](int r) {
    const double e = r - middle_row;
    kernel::LinearRow row{static_cast<float>(-middle_column), {}, {}, {}, {}, {}, {}};
    const double theta_row = theta + e * down.theta, phi_row = phi + e * down.phi;
    row.theta = static_cast<float>(theta_row);
    row.theta_rest = static_cast<float>(theta_row - static_cast<double>(row.theta));
    row.theta_step = static_cast<float>(along.theta);
    row.phi = static_cast<float>(phi_row);
    row.phi_rest = static_cast<float>(phi_row - static_cast<double>(row.phi));
    row.phi_step = static_cast<float>(along.phi);
    kernel::run_linear(row, columns_wide, map.theta_s_rad.row(r).data(), map.phi_s_rad.row(r).data());
    const ColumnRange visible = visible_columns(view, r, {0, columns});
    for (Grid<float>* grid : {&map.theta_s_rad, &map.phi_s_rad}) {
      const std::span<float> out = grid->row(r);
      std::fill(out.begin(), out.begin() + visible.first, NAN);
      std::fill(out.begin() + visible.last, out.end(), NAN);
    }
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
  return worst + single_bound_rad(frame_extent(view, rows, columns), view);
}

}  // namespace scatmap
