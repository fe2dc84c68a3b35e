#include "scatmap/angles/tile_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "scatmap/angles/angle_line.h"
#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/taylor_bound.h"
#include "scatmap/angles/tile_kernel.h"
#include "scatmap/base/parallel.h"
#include "scatmap/base/stream_copy.h"

namespace scatmap {
namespace {

constexpr int kWidest = 1024;  // columns of a tile

struct Tile {
  int first_row = 0, last_row = 0;
  ColumnRange columns;
  double middle_row() const { return 0.5 * (first_row + last_row - 1); }
  double middle_column() const { return 0.5 * (columns.first + columns.last - 1); }
  std::size_t rows() const { return static_cast<std::size_t>(last_row - first_row); }
};

// The rows of a tile taken together.
LineSize line_size(const SampleView& view, const Tile& tile) {
  const Vector3<double> middle = view.pixel(tile.middle_column(), tile.middle_row());
  const double half = 0.5 * static_cast<double>(tile.rows() - 1);
  const double rho = std::hypot(middle.x(), middle.y()), r = middle.norm();
  const double d_rho = half * std::hypot(view.row_step.x(), view.row_step.y()), d_r = half * view.row_step.norm();
  return {rho - d_rho,
          rho + d_rho,
          r - d_r,
          r + d_r,
          std::hypot(view.column_step.x(), view.column_step.y()),
          view.column_step.norm()};
}

// phi = 0 lies at y = 0, x < 0, the horizon at z = 0; corners bound a plane's coordinates.
bool off_seam_and_horizon(const SampleView& view, const Tile& tile) {
  bool left = false, up = false, down = false, above = true;
  for (const int row : {tile.first_row, tile.last_row - 1}) {
    for (const int column : {tile.columns.first, tile.columns.last - 1}) {
      const Vector3<double> ray = view.pixel(column, row);
      const double margin = 1e-6 * ray.norm();
      left = left || ray.x() < margin;
      up = up || ray.y() > -margin;
      down = down || ray.y() < margin;
      above = above && ray.z() > margin;
    }
  }
  return above && !(left && up && down);
}

// The least degree that serves a tile; nullopt if none does.
template <class T>
std::optional<int> degree_for(const SampleView& view, const Tile& tile, double truncation_rad) {
  const bool regular = view.detector_normal.dot(view.origin) > 0 && off_seam_and_horizon(view, tile) &&
                       is_near_line(view.pixel(tile.middle_column(), tile.middle_row()), view.row_step,
                                    0.5 * static_cast<double>(tile.rows() - 1));
  if (!regular) return std::nullopt;
  const LineSize size = line_size(view, tile);
  const double half = 0.5 * (tile.columns.size() - 1);
  for (int degree = kernel::kLeastTileDegree<T>; degree <= kernel::kTileDegree<T>; ++degree) {
    if (taylor_remainder_rad(size, half, degree) <= truncation_rad) return degree;
  }
  return std::nullopt;
}

// Some of a frame's tiles, spread over it: a plan is chosen by them, and each tile is then judged by itself.
template <class Work>
void for_sampled_tiles(int rows, int columns, int tile_columns, Work&& work) {
  constexpr int kSamples = 4;
  const int down = (rows + kernel::kTileRows - 1) / kernel::kTileRows,
            across = (columns + tile_columns - 1) / tile_columns;
  for (int i = 0; i < kSamples; ++i) {
    for (int k = 0; k < kSamples; ++k) {
      const int r = i * (down - 1) / (kSamples - 1) * kernel::kTileRows,
                c = k * (across - 1) / (kSamples - 1) * tile_columns;
      work(Tile{r, std::min(r + kernel::kTileRows, rows), {c, std::min(c + tile_columns, columns)}});
    }
  }
}

// What a plan costs, in ns; only ratios count, and only for the choice.
struct Prices {
  double pixel, pixel_per_degree, row, other_pixel;
};
template <class T>
constexpr Prices kPrices{0.08, 0.02, 18, 0.6};
template <>
constexpr Prices kPrices<double>{0.2, 0.03, 30, 1.0};

struct Cost {
  double total = 0;
  double pixels = 0, polynomial_pixels = 0;
};

template <class T>
Cost cost_of(const SampleView& view, int rows, int columns, const TilePlan& plan) {
  constexpr Prices kPrice = kPrices<T>;
  Cost cost;
  for_sampled_tiles(rows, columns, plan.columns, [&](const Tile& tile) {
    const double pixels = static_cast<double>(tile.rows()) * tile.columns.size();
    cost.pixels += pixels;
    if (const auto degree = degree_for<T>(view, tile, plan.truncation_rad)) {
      cost.total +=
          pixels * (kPrice.pixel + kPrice.pixel_per_degree * *degree) + kPrice.row * static_cast<double>(tile.rows());
      cost.polynomial_pixels += pixels;
    } else {
      cost.total += pixels * kPrice.other_pixel;
    }
  });
  return cost;
}

template <class T>
struct PreparedTile {
  Tile tile;
  std::optional<int> degree;  ///< of its polynomials; the rest is not filled without
  double theta_rad, phi_rad;  ///< of the middle
  kernel::TileCoefficients<kernel::kTileDegree<T>> along;
};

template <class T>
void prepare(const SampleView& view, PreparedTile<T>& out) {
  const Tile& tile = out.tile;
  const WideRay middle = reference_ray(view, tile.middle_column(), tile.middle_row());
  const double first_d = tile.first_row - tile.middle_row();
  kernel::NearSegment<double> near = near_segment<double>(middle, view.row_step, first_d);
  out.theta_rad = std::exchange(near.theta, 0);  // the rows' angles are taken from the middle's: nothing is rounded off
  out.phi_rad = std::exchange(near.phi, 0);
  kernel::run_near(near, tile.rows(), out.along.theta[0].data(), out.along.phi[0].data());
  const kernel::FarSegment<double> down = far_segment<double>(middle, view.row_step, first_d);
  const kernel::FarSegment<double> along = far_segment<double>(middle, view.column_step, 0);
  kernel::run_tile_series({first_d, down.x, down.y, down.z, down.x_step, down.y_step, down.z_step, along.x_step,
                           along.y_step, along.z_step},
                          out.along);
}

template <class T>
void write_polynomial_row(const PreparedTile<T>& t, int row, bool streamed, AngleMapOf<T>& map) {
  const Tile& tile = t.tile;
  const auto i = static_cast<std::size_t>(row - tile.first_row), at = static_cast<std::size_t>(tile.columns.first);
  const auto &theta = t.along.theta, &phi = t.along.phi;
  kernel::RowPolynomial<T> p{};
  p.first_d = static_cast<T>(tile.columns.first - tile.middle_column());
  p.theta = static_cast<T>(t.theta_rad + theta[0][i]);
  p.phi = static_cast<T>(t.phi_rad + phi[0][i]);
  p.theta_part[0] = static_cast<T>((t.theta_rad - static_cast<double>(p.theta)) + theta[0][i]);
  p.phi_part[0] = static_cast<T>((t.phi_rad - static_cast<double>(p.phi)) + phi[0][i]);
  for (std::size_t k = 1; k <= static_cast<std::size_t>(*t.degree); ++k) {
    p.theta_part[k] = static_cast<T>(theta[k][i]);
    p.phi_part[k] = static_cast<T>(phi[k][i]);
  }
  const auto n = static_cast<std::size_t>(tile.columns.size());
  T *to_theta = map.theta_s_rad.row(row).data() + at, *to_phi = map.phi_s_rad.row(row).data() + at;
  if (!streamed) return kernel::run_tile_row(*t.degree, p, n, to_theta, to_phi);
  alignas(64) std::array<T, kWidest> theta_row, phi_row;
  kernel::run_tile_row(*t.degree, p, n, theta_row.data(), phi_row.data());
  stream_copy(theta_row.data(), n, to_theta);
  stream_copy(phi_row.data(), n, to_phi);
}

template <class T>
std::span<T> part(Grid<T>& grid, int row, ColumnRange columns) {
  if (grid.empty()) return {};
  return grid.row(row).subspan(static_cast<std::size_t>(columns.first), static_cast<std::size_t>(columns.size()));
}

template <class T>
void write_other_row(const SampleView& view, ColumnRange columns, int row, AngleMapOf<T>& map) {
  AngleRow<T> out;
  out.theta_s_rad = part(map.theta_s_rad, row, columns);
  out.phi_s_rad = part(map.phi_s_rad, row, columns);
  angle_row(view, row, columns, out);
}

// Tiles side by side, written row after row: memory likes long runs.
constexpr int kGroup = 16;

template <class T>
void write_group(const SampleView& view, const TilePlan& plan, const Tile& group, bool streamed, AngleMapOf<T>& map) {
  std::array<PreparedTile<T>, kGroup> tiles;
  std::size_t n = 0;
  for (int c = group.columns.first; c < group.columns.last; c += plan.columns, ++n) {
    PreparedTile<T>& t = tiles[n];
    t.tile = {group.first_row, group.last_row, {c, std::min(c + plan.columns, group.columns.last)}};
    t.degree = degree_for<T>(view, t.tile, plan.truncation_rad);
    if (t.degree) prepare(view, t);
  }
  for (int row = group.first_row; row < group.last_row; ++row) {
    for (std::size_t i = 0; i < n; ++i) {
      const PreparedTile<T>& t = tiles[i];
      if (t.degree)
        write_polynomial_row(t, row, streamed, map);
      else
        write_other_row(view, t.tile.columns, row, map);
    }
  }
}

}  // namespace

template <class T>
TilePlan plan_tiles(const SampleView& view, int rows, int columns, double truncation_rad) {
  TilePlan best;
  double lowest = std::numeric_limits<double>::infinity();
  for (int width = 64; width <= kWidest; width *= 2) {
    TilePlan plan{width, truncation_rad, 0};
    const Cost cost = cost_of<T>(view, rows, columns, plan);
    if (!(cost.total < lowest * cost.pixels)) continue;
    lowest = cost.total / cost.pixels;
    plan.polynomial_share = cost.polynomial_pixels / cost.pixels;
    best = plan;
  }
  return best;
}

template <class T>
void write_tile_map(const SampleView& view, const TilePlan& plan, AngleMapOf<T>& map) {
  const int rows = map.theta_s_rad.rows(), columns = map.theta_s_rad.columns();
  map.theta_i_rad = incidence_angle(view);
  const bool streamed = 2 * sizeof(T) * map.theta_s_rad.size() >= kStreamedBytes;
  const int bands = (rows + kernel::kTileRows - 1) / kernel::kTileRows;
  for_each_index(bands, 1, [&](int band) {
    const int first = band * kernel::kTileRows, last = std::min(first + kernel::kTileRows, rows);
    for (int c = 0; c < columns; c += kGroup * plan.columns)
      write_group(view, plan, {first, last, {c, std::min(c + kGroup * plan.columns, columns)}}, streamed, map);
    for (int r = first; r < last; ++r) {
      AngleRow<T> rest;
      rest.solid_angle_sr = part(map.solid_angle_sr, r, {0, columns});
      if (!map.mask.empty()) rest.mask = map.mask.row(r);
      angle_row(view, r, {0, columns}, rest);
    }
    finish_streams();
  });
}

template TilePlan plan_tiles<float>(const SampleView&, int, int, double);
template TilePlan plan_tiles<double>(const SampleView&, int, int, double);
template void write_tile_map(const SampleView&, const TilePlan&, AngleMapOf<float>&);
template void write_tile_map(const SampleView&, const TilePlan&, AngleMapOf<double>&);

}  // namespace scatmap
