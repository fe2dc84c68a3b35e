#include "scatmap/compare/pixel_directions.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace scatmap {
namespace {

// Angle per pixel and tangent of the widest centred stretch of a line of pixels whose ends both have directions.
std::optional<Vector3<double>> mean_step(const PixelDirections& directions, PixelPosition centre, double half_columns,
                                         double half_rows) {
  for (double share = 1; share > 1e-3; share *= 0.9) {
    const double dc = share * half_columns, dr = share * half_rows, half = std::hypot(dc, dr);
    const Vector3<double> low = directions({centre.column - dc, centre.row - dr}),
                          high = directions({centre.column + dc, centre.row + dr});
    if (!(half > 0) || !low.allFinite() || !high.allFinite()) continue;
    return (high - low).normalized() * (std::tan(angle_between<double>(low, high) / 2) / half);
  }
  return std::nullopt;
}

double closed_form_difference(const SampleView& a, const SampleView& b, PixelPosition at) {
  const auto p = pixel_of_direction(a, b.pixel(at.column, at.row));
  return p ? std::hypot(p->column - at.column, p->row - at.row) : std::numeric_limits<double>::infinity();
}

// 0 where one of the maps has no direction.
double first_order_difference(const PixelDirections& a, const PixelDirections& b, PixelPosition at) {
  const Vector3<double> here = a(at).normalized(), there = b(at).normalized();
  Eigen::Matrix<double, 3, 2> step;
  step << a.change(at, 1, 0), a.change(at, 0, 1);
  if (!here.allFinite() || !there.allFinite() || !step.allFinite()) return 0;
  return step.colPivHouseholderQr().solve(there - here).norm();
}

}  // namespace

PixelDirections::PixelDirections(const BrdfMap& map) : map_(map) {
  if (!map.instrument.lens_cameramodel) view_ = sample_view(map.instrument, map.pose);
}

Vector3<double> PixelDirections::operator()(PixelPosition at) const {
  return view_ ? view_->pixel(at.column, at.row) : interpolated_direction(map_.angles, at);
}

Vector3<double> PixelDirections::change(PixelPosition at, double columns, double rows) const {
  if (view_) return columns * view_->column_step + rows * view_->row_step;
  // At the array's edge the difference is taken from just inside.
  const double last_column = map_.mask.columns() - 1, last_row = map_.mask.rows() - 1;
  const double c = std::clamp(at.column, std::min(0.5, last_column / 2), std::max(last_column - 0.5, last_column / 2));
  const double r = std::clamp(at.row, std::min(0.5, last_row / 2), std::max(last_row - 0.5, last_row / 2));
  return (*this)({c + columns / 2, r + rows / 2}) - (*this)({c - columns / 2, r - rows / 2});
}

SampleView mean_view(const BrdfMap& map) {
  SampleView view = sample_view(map.instrument, map.pose);
  if (!map.instrument.lens_cameramodel) return view;
  const PixelDirections directions(map);
  const double half_columns = 0.5 * (map.mask.columns() - 1), half_rows = 0.5 * (map.mask.rows() - 1);
  const PixelPosition centre{half_columns, half_rows};
  const auto column_step = mean_step(directions, centre, half_columns, 0),
             row_step = mean_step(directions, centre, 0, half_rows);
  const Vector3<double> ahead = directions(centre);
  if (!column_step || !row_step || !ahead.allFinite()) return view;
  view.column_step = *column_step;
  view.row_step = *row_step;
  view.origin = ahead - half_columns * view.column_step - half_rows * view.row_step;
  return view;
}

double direction_difference_px(const BrdfMap& a, const BrdfMap& b) {
  const bool flat = !a.instrument.lens_cameramodel && !b.instrument.lens_cameramodel;
  const SampleView view_a = sample_view(a.instrument, a.pose), view_b = sample_view(b.instrument, b.pose);
  const PixelDirections directions_a(a), directions_b(b);
  const double last_column = a.mask.columns() - 1, last_row = a.mask.rows() - 1;
  double largest = 0;
  for (const double x : {0.0, 0.5, 1.0}) {
    for (const double y : {0.0, 0.5, 1.0}) {
      const PixelPosition at{x * last_column, y * last_row};
      largest = std::max(largest, flat ? closed_form_difference(view_a, view_b, at)
                                       : first_order_difference(directions_a, directions_b, at));
    }
  }
  return largest;
}

}  // namespace scatmap
