#include "scatmap/brdf/pose_tiles.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scatmap/brdf/pose_kernels.h"

namespace scatmap {
namespace {

struct Slope {
  double x, y;
};

// Everything about one pixel that does not depend on which parameter changes.
struct PixelState {
  Vector3<double> ray, v, half_sum;
  double r, r2, facing;
  Slope per_column, per_row;
  double determinant;
};

// Change of the half vector's slopes (ux/uz, uy/uz), u = b + v, when the ray changes by d_ray and b by d_source.
Slope slope_change(const PixelState& p, const Vector3<double>& d_ray, const Vector3<double>& d_source) {
  const Vector3<double>& u = p.half_sum;
  const Vector3<double> du = (d_ray - p.v * p.v.dot(d_ray)) / p.r + d_source;
  return {(du.x() - u.x() / u.z() * du.z()) / u.z(), (du.y() - u.y() / u.z() * du.z()) / u.z()};
}

PixelState pixel_state(const SampleView& view, double row, double column) {
  PixelState p;
  p.ray = view.pixel(column, row);
  p.r2 = p.ray.squaredNorm();
  p.r = std::sqrt(p.r2);
  p.v = p.ray / p.r;
  p.half_sum = view.to_source + p.v;
  p.facing = view.detector_normal.dot(p.ray);
  p.per_column = slope_change(p, view.column_step, Vector3<double>::Zero());
  p.per_row = slope_change(p, view.row_step, Vector3<double>::Zero());
  p.determinant = p.per_column.x * p.per_row.y - p.per_column.y * p.per_row.x;
  return p;
}

// Near the horizon, or seen from close by, 1/cos theta_s and the distance change too fast for a parabola.
bool varies_slowly(const SampleView& view, int first_row, int last_row, const PoseTiles::Tile& tile) {
  constexpr double kMostChange = 1.2;
  double low_z = HUGE_VAL, high_z = 0, low_r = HUGE_VAL, high_r = 0;
  for (const int row : {first_row, last_row - 1}) {
    for (const int column : {tile.first_column, tile.last_column - 1}) {
      const Vector3<double> ray = view.pixel(column, row);
      low_z = std::min(low_z, ray.z());
      high_z = std::max(high_z, ray.z());
      low_r = std::min(low_r, ray.norm());
      high_r = std::max(high_r, ray.norm());
    }
  }
  return low_z > 0 && high_z < kMostChange * low_z && high_r < kMostChange * low_r;
}

double difference(double before, double here, double after) {
  if (std::isfinite(before) && std::isfinite(after)) return 0.5 * (after - before);
  if (std::isfinite(after)) return after - here;
  if (std::isfinite(before)) return here - before;
  return 0;
}

// t of a pixel is (index − first)·per_step; a tile of one pixel has t = 0.
double per_step(int first, int last) { return last - first > 1 ? 1.0 / (last - 1 - first) : 0; }

}  // namespace

Gradient gradient_at(const GradientRows& rows, int column) {
  const double here = rows.here[column];
  return {here, difference(rows.here[column - 1], here, rows.here[column + 1]),
          difference(rows.above[column], here, rows.below[column])};
}

void pose_actions(const SampleView& view, const std::vector<ViewChange>& changes, double row, double column,
                  PoseAction* actions) {
  const PixelState p = pixel_state(view, row, column);
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const ViewChange& change = changes[k];
    const Vector3<double> d_ray = change.of_pixel(column, row);
    const double along = p.ray.dot(d_ray) / p.r2;
    const double d_ln_omega =
        change.ln_area + (change.detector_normal.dot(p.ray) + view.detector_normal.dot(d_ray)) / p.facing - 3 * along;
    const double d_ln_cos = d_ray.z() / p.ray.z() - along;
    const Slope s = slope_change(p, d_ray, change.to_source);
    actions[k] = {d_ln_omega + d_ln_cos, (s.x * p.per_row.y - s.y * p.per_row.x) / p.determinant,
                  (p.per_column.x * s.y - p.per_column.y * s.x) / p.determinant};
  }
}

PoseTiles::PoseTiles(const SampleView& view, std::vector<ViewChange> changes, int rows, int columns)
    : view_(view), changes_(std::move(changes)), rows_(rows), columns_(columns) {}

void PoseTiles::fill_form(Tile& tile, int first_row, int last_row) const {
  std::array<std::array<std::array<double, 8>, 3>, 3> node{};  // [row][column][coefficient]
  std::vector<PoseAction> actions(changes_.size());
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      pose_actions(view_, changes_, first_row + 0.5 * static_cast<double>(i) * (last_row - 1 - first_row),
                   tile.first_column + 0.5 * static_cast<double>(j) * (tile.last_column - 1 - tile.first_column),
                   actions.data());
      auto& q = node[i][j];
      for (const PoseAction& a : actions) {
        q[0] += a.relative * a.relative;
        q[1] += 2 * a.relative * a.columns;
        q[2] += 2 * a.relative * a.rows;
        q[3] += a.columns * a.columns;
        q[4] += 2 * a.columns * a.rows;
        q[5] += a.rows * a.rows;
      }
    }
  }
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t k = 0; k < 8; ++k) {
      const double first = node[0][j][k], middle = node[1][j][k], last = node[2][j][k];
      tile.a[j][k] = first;
      tile.b[j][k] = 4 * middle - 3 * first - last;
      tile.c[j][k] = 2 * (first - 2 * middle + last);
    }
  }
}

std::vector<PoseTiles::Tile> PoseTiles::band(int index) const {
  const int first_row = index * kPoseTile, last_row = std::min(rows_, first_row + kPoseTile);
  std::vector<Tile> out(static_cast<std::size_t>((columns_ + kPoseTile - 1) / kPoseTile));
  int column = 0;
  for (Tile& tile : out) {
    tile.first_column = column;
    tile.last_column = column = std::min(columns_, column + kPoseTile);
    tile.exact = !varies_slowly(view_, first_row, last_row, tile);
    if (!tile.exact) fill_form(tile, first_row, last_row);
  }
  return out;
}

double PoseTiles::exact_square(int row, int column, const Gradient& g) const {
  if (std::isnan(g.f)) return g.f;
  std::vector<PoseAction> actions(changes_.size());
  pose_actions(view_, changes_, row, column, actions.data());
  double sum = 0;
  for (const PoseAction& a : actions) {
    const double s = g.f * a.relative + g.per_column * a.columns + g.per_row * a.rows;
    sum += s * s;
  }
  return sum;
}

void PoseTiles::squares(const std::vector<Tile>& band, int row, const GradientRows& f, float* out) const {
  const int first_row = row / kPoseTile * kPoseTile, last_row = std::min(rows_, first_row + kPoseTile);
  const double t = (row - first_row) * per_step(first_row, last_row);
  for (const Tile& tile : band) {
    if (tile.exact) {
      for (int c = tile.first_column; c < tile.last_column; ++c)
        out[c] = static_cast<float>(exact_square(row, c, gradient_at(f, c)));
      continue;
    }
    const double per_column = per_step(tile.first_column, tile.last_column);
    RowForm form;
    row_form(tile, t, form);
    if (!form_squares(form, per_column, f, tile.first_column, tile.last_column, out)) continue;
    for (int c = tile.first_column; c < tile.last_column; ++c) {  // beside a NaN: with what neighbours there are
      if (!std::isnan(out[c])) continue;
      const double s = form_square(form, (c - tile.first_column) * per_column, gradient_at(f, c));
      out[c] = static_cast<float>(s > 0 ? s : 0 * s);
    }
  }
}

}  // namespace scatmap
