#include "scatmap/report/picture_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scatmap/base/units.h"

namespace scatmap {
namespace {

struct AxisScale {
  double deg_per_px;
  bool reversed;  // pixels are stored against the drawn direction
};

// Mean over the frame: a flat detector's scale changes by half the square of its half angle, 0.02 % at 1.2 degrees.
AxisScale axis_scale(const Vector3<double>& centre, const Vector3<double>& step, int pixels,
                     const Vector3<double>& drawn) {
  const double half = 0.5 * std::max(1, pixels - 1);
  const double angle = angle_between<double>(centre - half * step, centre + half * step);
  return {angle / (2 * half) * kDegPerRad, step.dot(drawn) < 0};
}

template <class T>
double block_mean(const Grid<T>& values, const Grid<Mask>& mask, int row, int column, int block) {
  double sum = 0;
  int count = 0;
  for (int r = row; r < std::min(row + block, values.rows()); ++r) {
    for (int c = column; c < std::min(column + block, values.columns()); ++c) {
      if (mask(r, c) != 0 || !std::isfinite(values(r, c))) continue;
      sum += static_cast<double>(values(r, c));
      ++count;
    }
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

template <class T>
Raster make_raster(const Grid<T>& values, const Grid<Mask>& mask, const SampleView& view, int most_cells) {
  Raster out;
  const int side = std::max(values.rows(), values.columns());
  out.block = std::max(1, (side + most_cells - 1) / most_cells);
  out.columns = (values.columns() + out.block - 1) / out.block;
  out.rows = (values.rows() + out.block - 1) / out.block;

  const Vector3<double> centre = view.pixel(0.5 * (values.columns() - 1), 0.5 * (values.rows() - 1));
  const Vector3<double> d = centre.normalized();
  const Vector3<double> out_of_plane = d.cross(Vector3<double>::UnitX());
  const AxisScale x = axis_scale(centre, view.column_step, values.columns(), out_of_plane.cross(d));
  const AxisScale y = axis_scale(centre, view.row_step, values.rows(), out_of_plane);
  out.step_x_deg = out.block * x.deg_per_px;
  out.step_y_deg = out.block * y.deg_per_px;
  // Blocks begin at the first pixel stored; what the last block lacks is missing at the drawn end opposite to it.
  const auto first = [&](const AxisScale& axis, int pixels, int cells) {
    const double first_block = 0.5 * (out.block - pixels) * axis.deg_per_px;
    return axis.reversed ? -first_block - (cells - 1) * out.block * axis.deg_per_px : first_block;
  };
  out.first_x_deg = first(x, values.columns(), out.columns);
  out.first_y_deg = first(y, values.rows(), out.rows);

  out.values.reserve(static_cast<std::size_t>(out.rows) * static_cast<std::size_t>(out.columns));
  for (int r = 0; r < out.rows; ++r) {
    for (int c = 0; c < out.columns; ++c) {
      const int row = out.block * (y.reversed ? out.rows - 1 - r : r);
      const int column = out.block * (x.reversed ? out.columns - 1 - c : c);
      out.values.push_back(static_cast<float>(block_mean(values, mask, row, column, out.block)));
    }
  }
  return out;
}

}  // namespace

Raster raster(const Grid<double>& values, const Grid<Mask>& mask, const SampleView& view, int most_cells) {
  return make_raster(values, mask, view, most_cells);
}

Raster raster(const Grid<float>& values, const Grid<Mask>& mask, const SampleView& view, int most_cells) {
  return make_raster(values, mask, view, most_cells);
}

}  // namespace scatmap
