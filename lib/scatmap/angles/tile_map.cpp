#include "scatmap/angles/tile_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "scatmap/angles/angle_line.h"
#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/taylor_bound.h"
#include "scatmap/angles/tile_kernel.h"
#include "scatmap/base/parallel.h"

namespace scatmap {
namespace {

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

bool polynomial_serves(const SampleView& view, const Tile& tile, int degree, double truncation_rad) {
  const double half = 0.5 * (tile.columns.size() - 1);
  return view.detector_normal.dot(view.origin) > 0 && off_seam_and_horizon(view, tile) &&
         taylor_remainder_rad(line_size(view, tile), half, degree) <= truncation_rad;
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
struct Cost {
  double total = 0;
  double pixels = 0, polynomial_pixels = 0;
};

Cost cost_of(const SampleView& view, int rows, int columns, const TilePlan& plan) {
  constexpr double kPixel = 0.08, kPixelPerDegree = 0.02, kRow = 18, kSinglePixel = 0.6;
  Cost cost;
  for_sampled_tiles(rows, columns, plan.columns, [&](const Tile& tile) {
    const double pixels = static_cast<double>(tile.rows()) * tile.columns.size();
    cost.pixels += pixels;
    if (polynomial_serves(view, tile, plan.degree, plan.truncation_rad)) {
      cost.total += pixels * (kPixel + kPixelPerDegree * plan.degree) + kRow * static_cast<double>(tile.rows());
      cost.polynomial_pixels += pixels;
    } else {
      cost.total += pixels * kSinglePixel;
    }
  });
  return cost;
}

kernel::TileCoefficients coefficients(const SampleView& view, const Tile& tile) {
  const WideRay middle = wide_ray(view, tile.middle_column(), tile.middle_row());
  const double first_d = tile.first_row - tile.middle_row();
  const kernel::FarSegment<double> down = far_segment<double>(middle, view.row_step, first_d);
  const kernel::FarSegment<double> along = far_segment<double>(middle, view.column_step, 0);
  kernel::TileCoefficients c;
  kernel::run_far(down, tile.rows(), c.theta[0].data(), c.phi[0].data());
  kernel::run_tile_series({first_d, down.x, down.y, down.z, down.x_step, down.y_step, down.z_step, along.x_step,
                           along.y_step, along.z_step},
                          tile.rows(), c);
  return c;
}

void write_polynomial_row(const Tile& tile, const kernel::TileCoefficients& c, int degree, int row,
                          AngleMapOf<float>& map) {
  const auto i = static_cast<std::size_t>(row - tile.first_row), at = static_cast<std::size_t>(tile.columns.first);
  kernel::RowPolynomial p{};
  p.first_d = static_cast<float>(tile.columns.first - tile.middle_column());
  p.theta = static_cast<float>(c.theta[0][i]);
  p.phi = static_cast<float>(c.phi[0][i]);
  p.theta_part[0] = static_cast<float>(c.theta[0][i] - static_cast<double>(p.theta));
  p.phi_part[0] = static_cast<float>(c.phi[0][i] - static_cast<double>(p.phi));
  for (std::size_t k = 1; k <= static_cast<std::size_t>(degree); ++k) {
    p.theta_part[k] = static_cast<float>(c.theta[k][i]);
    p.phi_part[k] = static_cast<float>(c.phi[k][i]);
  }
  kernel::run_tile_row(degree, p, static_cast<std::size_t>(tile.columns.size()), map.theta_s_rad.row(row).data() + at,
                       map.phi_s_rad.row(row).data() + at);
}

std::span<float> part(Grid<float>& grid, int row, ColumnRange columns) {
  if (grid.empty()) return {};
  return grid.row(row).subspan(static_cast<std::size_t>(columns.first), static_cast<std::size_t>(columns.size()));
}

void write_single_row(const SampleView& view, ColumnRange columns, int row, AngleMapOf<float>& map) {
  AngleRow<float> out;
  out.theta_s_rad = part(map.theta_s_rad, row, columns);
  out.phi_s_rad = part(map.phi_s_rad, row, columns);
  angle_row(view, row, columns, out);
}

// Tiles side by side, written row after row: memory likes long runs.
constexpr int kGroup = 16;

struct PreparedTile {
  Tile tile;
  bool polynomial;
  kernel::TileCoefficients coefficients;
};

void write_group(const SampleView& view, const TilePlan& plan, const Tile& group, AngleMapOf<float>& map) {
  std::array<PreparedTile, kGroup> tiles;
  std::size_t n = 0;
  for (int c = group.columns.first; c < group.columns.last; c += plan.columns, ++n) {
    PreparedTile& t = tiles[n];
    t.tile = {group.first_row, group.last_row, {c, std::min(c + plan.columns, group.columns.last)}};
    t.polynomial = polynomial_serves(view, t.tile, plan.degree, plan.truncation_rad);
    if (t.polynomial) t.coefficients = coefficients(view, t.tile);
  }
  for (int row = group.first_row; row < group.last_row; ++row) {
    for (std::size_t i = 0; i < n; ++i) {
      const PreparedTile& t = tiles[i];
      if (t.polynomial)
        write_polynomial_row(t.tile, t.coefficients, plan.degree, row, map);
      else
        write_single_row(view, t.tile.columns, row, map);
    }
  }
}

}  // namespace

TilePlan plan_tiles(const SampleView& view, int rows, int columns, double truncation_rad) {
  TilePlan best;
  double lowest = std::numeric_limits<double>::infinity();
  for (int degree = 1; degree <= kernel::kTileDegree; ++degree) {
    for (int width = 64; width <= 1024; width *= 2) {
      TilePlan plan{width, degree, truncation_rad, 0};
      const Cost cost = cost_of(view, rows, columns, plan);
      if (!(cost.total < lowest * cost.pixels)) continue;
      lowest = cost.total / cost.pixels;
      plan.polynomial_share = cost.polynomial_pixels / cost.pixels;
      best = plan;
    }
  }
  return best;
}

void write_tile_map(const SampleView& view, const TilePlan& plan, AngleMapOf<float>& map) {
  const Grid<float>& shape = map.theta_s_rad;
  const int rows = shape.rows(), columns = shape.columns();
  map.theta_i_rad = incidence_angle(view);
  const int bands = (rows + kernel::kTileRows - 1) / kernel::kTileRows;
  for_each_row(bands, [&](int band) {
    const int first = band * kernel::kTileRows, last = std::min(first + kernel::kTileRows, rows);
    for (int c = 0; c < columns; c += kGroup * plan.columns)
      write_group(view, plan, {first, last, {c, std::min(c + kGroup * plan.columns, columns)}}, map);
    for (int r = first; r < last; ++r) {
      AngleRow<float> rest;
      rest.solid_angle_sr = part(map.solid_angle_sr, r, {0, columns});
      if (!map.mask.empty()) rest.mask = map.mask.row(r);
      angle_row(view, r, {0, columns}, rest);
    }
  });
}

}  // namespace scatmap
