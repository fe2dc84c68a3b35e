#include "scatmap/brdf/pose_tiles.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scatmap/brdf/pose_kernels.h"

namespace scatmap {
namespace {

PixelState pixel_state(const SampleView& view, double row, double column) {
  const Vector3<double> ray = view.pixel(column, row), n = view.detector_normal;
  const double r2 = ray.squaredNorm(), r = std::sqrt(r2);
  const Vector3<double> v = ray / r, u = view.to_source + v;
  // Change of the half vector's slopes along a step of the ray.
  const auto slopes = [&](const Vector3<double>& step) {
    const Vector3<double> du = (step - v * v.dot(step)) / r;
    return Eigen::Vector2d((du.x() - u.x() / u.z() * du.z()) / u.z(), (du.y() - u.y() / u.z() * du.z()) / u.z());
  };
  Eigen::Vector2d per_column = slopes(view.column_step), per_row = slopes(view.row_step);
  const double determinant = per_column.x() * per_row.y() - per_column.y() * per_row.x();
  per_column /= determinant;
  per_row /= determinant;
  return {row,   column,        ray.x(),        ray.y(),        ray.z(),        v.x(),       v.y(),
          v.z(), u.x() / u.z(), u.y() / u.z(),  1 / r,          1 / r2,         1 / u.z(),   n.x(),
          n.y(), n.z(),         1 / n.dot(ray), per_column.x(), per_column.y(), per_row.x(), per_row.y()};
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

Gradient gradient_at(const GradientRows& rows, int index) {
  const double here = rows.here[index];
  return {here, difference(rows.here[index - 1], here, rows.here[index + 1]),
          difference(rows.above[index], here, rows.below[index])};
}

ChangeRows::ChangeRows(const std::vector<ViewChange>& changes) : size_(changes.size()), data_(kNumbers * size_) {
  for (std::size_t k = 0; k < size_; ++k) {
    const ViewChange& change = changes[k];
    std::size_t number = 0;
    for (const auto* vector :
         {&change.origin, &change.column_step, &change.row_step, &change.detector_normal, &change.to_source}) {
      for (const double value : *vector) data_[number++ * size_ + k] = value;
    }
    data_[number * size_ + k] = change.ln_area;
  }
}

void pose_actions(const SampleView& view, const ChangeRows& changes, double row, double column, PoseActions& actions) {
  fill_actions(pixel_state(view, row, column), changes, actions);
}

PoseTiles::PoseTiles(const SampleView& view, const std::vector<ViewChange>& changes, int rows, int columns)
    : view_(view), changes_(changes), rows_(rows), columns_(columns) {}

void PoseTiles::fill_form(Tile& tile, int first_row, int last_row) const {
  std::array<std::array<std::array<double, 8>, 3>, 3> node{};  // [row][column][coefficient]
  PoseActions actions(changes_.size());
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      pose_actions(view_, changes_, first_row + 0.5 * static_cast<double>(i) * (last_row - 1 - first_row),
                   tile.first_column + 0.5 * static_cast<double>(j) * (tile.last_column - 1 - tile.first_column),
                   actions);
      auto& q = node[i][j];
      for (std::size_t k = 0; k < changes_.size(); ++k) {
        const double relative = actions.relative[k], columns = actions.columns[k], rows = actions.rows[k];
        q[0] += relative * relative;
        q[1] += 2 * relative * columns;
        q[2] += 2 * relative * rows;
        q[3] += columns * columns;
        q[4] += 2 * columns * rows;
        q[5] += rows * rows;
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
  PoseActions actions(changes_.size());
  pose_actions(view_, changes_, row, column, actions);
  double sum = 0;
  for (std::size_t k = 0; k < changes_.size(); ++k) {
    const double s = g.f * actions.relative[k] + g.per_column * actions.columns[k] + g.per_row * actions.rows[k];
    sum += s * s;
  }
  return sum;
}

namespace {

GradientRows from(const GradientRows& f, int index) { return {f.above + index, f.here + index, f.below + index}; }

PoseRow from(const PoseRow& out, int index) {
  if (out.u_total == nullptr) return {out.u_pose + index};
  return {out.u_pose + index, out.u_random + index, out.u_total + index};
}

void put(double square, int index, const PoseRow& out) {
  out.u_pose[index] = static_cast<float>(std::sqrt(square));
  if (out.u_total == nullptr) return;
  const double random = out.u_random[index];
  out.u_total[index] = static_cast<float>(std::sqrt(random * random + square));
}

}  // namespace

void PoseTiles::fill_row(std::span<const Tile> tiles, int row, const GradientRows& f, const PoseRow& out) const {
  const int first_row = row / kPoseTile * kPoseTile, last_row = std::min(rows_, first_row + kPoseTile);
  const double t = (row - first_row) * per_step(first_row, last_row);
  for (const Tile& tile : tiles) {
    const int at = tile.first_column - tiles.front().first_column, pixels = tile.last_column - tile.first_column;
    const GradientRows of_tile = from(f, at);
    const PoseRow to = from(out, at);
    if (tile.exact) {
      for (int i = 0; i < pixels; ++i) put(exact_square(row, tile.first_column + i, gradient_at(of_tile, i)), i, to);
      continue;
    }
    const auto per_column = static_cast<float>(per_step(tile.first_column, tile.last_column));
    RowForm form;
    row_form(tile, t, form);
    const Span absent = form_row(form, per_column, of_tile, pixels, to);
    for (int i = absent.first; i < absent.last; ++i) {  // beside a NaN: with what neighbours there are
      if (!std::isnan(to.u_pose[i])) continue;
      put(static_cast<double>(form_square(form, static_cast<float>(i) * per_column, gradient_at(of_tile, i))), i, to);
    }
  }
}

}  // namespace scatmap
