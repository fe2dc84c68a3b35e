#include "scatmap/brdf/pose_uncertainty.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "scatmap/angles/view_change.h"

namespace scatmap {
namespace {

struct Slope {
  double x, y;
};

// Change of the half vector's slopes (ux/uz, uy/uz), u = b + v, when the ray changes by d_ray and b by d_source.
Slope slope_change(const Vector3<double>& ray, double r, const Vector3<double>& u, const Vector3<double>& d_ray,
                   const Vector3<double>& d_source) {
  const Vector3<double> v = ray / r;
  const Vector3<double> du = (d_ray - v * v.dot(d_ray)) / r + d_source;
  return {(du.x() - u.x() / u.z() * du.z()) / u.z(), (du.y() - u.y() / u.z() * du.z()) / u.z()};
}

// Everything about one pixel that does not depend on which parameter changes.
struct PixelState {
  Vector3<double> ray, half_sum;
  double r, r2, facing;
  Slope per_column, per_row;
  double determinant;
};

PixelState pixel_state(const SampleView& view, double row, double column) {
  PixelState p;
  p.ray = view.pixel(column, row);
  p.r2 = p.ray.squaredNorm();
  p.r = std::sqrt(p.r2);
  p.half_sum = view.to_source + p.ray / p.r;
  p.facing = view.detector_normal.dot(p.ray);
  p.per_column = slope_change(p.ray, p.r, p.half_sum, view.column_step, Vector3<double>::Zero());
  p.per_row = slope_change(p.ray, p.r, p.half_sum, view.row_step, Vector3<double>::Zero());
  p.determinant = p.per_column.x * p.per_row.y - p.per_column.y * p.per_row.x;
  return p;
}

// How a change acts on a pixel: f changes by f·relative + per_column·columns + per_row·rows.
struct Action {
  double relative, columns, rows;
};

Action action(const SampleView& view, const PixelState& p, const ViewChange& change, double row, double column) {
  const Vector3<double> d_ray = change.origin + column * change.column_step + row * change.row_step;
  const double along = p.ray.dot(d_ray) / p.r2;
  const double d_ln_omega =
      change.ln_area + (change.detector_normal.dot(p.ray) + view.detector_normal.dot(d_ray)) / p.facing - 3 * along;
  const double d_ln_cos = d_ray.z() / p.ray.z() - along;
  const Slope s = slope_change(p.ray, p.r, p.half_sum, d_ray, change.to_source);
  return {d_ln_omega + d_ln_cos, (s.x * p.per_row.y - s.y * p.per_row.x) / p.determinant,
          (p.per_column.x * s.y - p.per_column.y * s.x) / p.determinant};
}

struct Gradient {
  double f, per_column, per_row;
};

double difference(double before, double here, double after) {
  if (std::isfinite(before) && std::isfinite(after)) return 0.5 * (after - before);
  if (std::isfinite(after)) return after - here;
  if (std::isfinite(before)) return here - before;
  return 0;
}

Gradient gradient(const Grid<double>& f, int row, int column) {
  const auto at = [&](int r, int c) {
    return r < 0 || c < 0 || r >= f.rows() || c >= f.columns() ? std::nan("") : f(r, c);
  };
  const double here = f(row, column);
  return {here, difference(at(row, column - 1), here, at(row, column + 1)),
          difference(at(row - 1, column), here, at(row + 1, column))};
}

}  // namespace

struct PoseSensitivities::Parts {
  SampleView view;
  std::vector<ViewChange> changes;
  const Grid<double>& expected;
};

PoseSensitivities::PoseSensitivities(const Instrument& instrument, const Pose& pose,
                                     const Grid<double>& expected_per_sr)
    : parts_(std::make_unique<Parts>(
          Parts{sample_view(instrument, pose), calibration_changes(instrument, pose), expected_per_sr})) {}

PoseSensitivities::~PoseSensitivities() = default;

std::size_t PoseSensitivities::count() const { return parts_->changes.size(); }

void PoseSensitivities::at(int row, int column, std::span<double> out) const {
  const Gradient g = gradient(parts_->expected, row, column);
  const PixelState p = pixel_state(parts_->view, row, column);
  for (std::size_t k = 0; k < out.size(); ++k) {
    const Action a = action(parts_->view, p, parts_->changes[k], row, column);
    out[k] = g.f * a.relative + g.per_column * a.columns + g.per_row * a.rows;
  }
}

namespace {

// The norm over all changes is a quadratic form in (f, per_column, per_row), and its six coefficients vary smoothly
// over the detector: rr, rc, ry, cc, cy, yy with r relative, c columns, y rows.
using Form = std::array<double, 6>;

Form form_at(const SampleView& view, const std::vector<ViewChange>& changes, double row, double column) {
  const PixelState p = pixel_state(view, row, column);
  Form out{};
  for (const ViewChange& change : changes) {
    const Action a = action(view, p, change, row, column);
    const Form products{a.relative * a.relative, 2 * a.relative * a.columns, 2 * a.relative * a.rows,
                        a.columns * a.columns,   2 * a.columns * a.rows,     a.rows * a.rows};
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += products[i];
  }
  return out;
}

// a + b t + c t² through values at t = 0, 1/2, 1.
struct Parabola {
  double a, b, c;
  double at(double t) const { return a + t * (b + t * c); }
};

Parabola through(double first, double middle, double last) {
  return {first, -3 * first + 4 * middle - last, 2 * first - 4 * middle + 2 * last};
}

struct Tile {
  int first_row, last_row, first_column, last_column;  // last: one past
};

// Near the horizon, or seen from close by, 1/cos theta_s and the distance change too fast for a parabola.
bool varies_slowly(const SampleView& view, const Tile& tile) {
  constexpr double kMostChange = 1.2;
  double low_z = HUGE_VAL, high_z = 0, low_r = HUGE_VAL, high_r = 0;
  for (const int row : {tile.first_row, tile.last_row - 1}) {
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

void exact_tile(const SampleView& view, const std::vector<ViewChange>& changes, const Tile& tile, const Grid<double>& f,
                Grid<float>& out) {
  for (int row = tile.first_row; row < tile.last_row; ++row) {
    for (int c = tile.first_column; c < tile.last_column; ++c) {
      const Gradient g = gradient(f, row, c);
      const PixelState p = pixel_state(view, row, c);
      double sum = 0;
      for (const ViewChange& change : changes) {
        const Action a = action(view, p, change, row, c);
        const double s = g.f * a.relative + g.per_column * a.columns + g.per_row * a.rows;
        sum += s * s;
      }
      out(row, c) = static_cast<float>(std::sqrt(sum));
    }
  }
}

// Nine exact forms, biquadratic in between.
struct TileForm {
  std::array<std::array<Parabola, 3>, 6> down;  // per coefficient: at the tile's left, middle and right column
  TileForm(const SampleView& view, const std::vector<ViewChange>& changes, const Tile& tile) {
    std::array<std::array<Form, 3>, 3> node;  // [row][column]
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        node[i][j] =
            form_at(view, changes, tile.first_row + 0.5 * static_cast<double>(i) * (tile.last_row - 1 - tile.first_row),
                    tile.first_column + 0.5 * static_cast<double>(j) * (tile.last_column - 1 - tile.first_column));
      }
    }
    for (std::size_t k = 0; k < 6; ++k) {
      for (std::size_t j = 0; j < 3; ++j) down[k][j] = through(node[0][j][k], node[1][j][k], node[2][j][k]);
    }
  }
  std::array<Parabola, 6> row(double t) const {
    std::array<Parabola, 6> out{};
    for (std::size_t k = 0; k < 6; ++k) out[k] = through(down[k][0].at(t), down[k][1].at(t), down[k][2].at(t));
    return out;
  }
};

double squared_norm(const std::array<Parabola, 6>& q, double t, const Gradient& g) {
  return g.f * (g.f * q[0].at(t) + g.per_column * q[1].at(t) + g.per_row * q[2].at(t)) +
         g.per_column * (g.per_column * q[3].at(t) + g.per_row * q[4].at(t)) + g.per_row * g.per_row * q[5].at(t);
}

// One row of a tile: central differences, then again with what neighbours there are where those gave NaN.
void tile_row(const std::array<Parabola, 6>& q, const Tile& tile, int row, const Grid<double>& f, Grid<float>& out) {
  const double per_column =
      tile.last_column - tile.first_column > 1 ? 1.0 / (tile.last_column - 1 - tile.first_column) : 0;
  const bool inner_row = row > 0 && row + 1 < f.rows();
  const int first = std::max(1, tile.first_column), last = std::min(f.columns() - 1, tile.last_column);
  float* u = out.row(row).data();
  std::fill(u + tile.first_column, u + tile.last_column, std::nanf(""));
  if (inner_row) {
    const double *here = f.row(row).data(), *above = f.row(row - 1).data(), *below = f.row(row + 1).data();
    for (int c = first; c < last; ++c) {
      const Gradient g{here[c], 0.5 * (here[c + 1] - here[c - 1]), 0.5 * (below[c] - above[c])};
      const double t = (c - tile.first_column) * per_column;
      u[c] = static_cast<float>(squared_norm(q, t, g));  // no branch and no root here: this loop becomes vector code
    }
  }
  for (int c = tile.first_column; c < tile.last_column; ++c) {
    if (u[c] > 0) {
      u[c] = std::sqrt(u[c]);
      continue;
    }
    const double square = squared_norm(q, (c - tile.first_column) * per_column, gradient(f, row, c));
    u[c] = static_cast<float>(square > 0 ? std::sqrt(square) : 0 * square);  // NaN stays NaN
  }
}

}  // namespace

std::optional<Grid<float>> pose_uncertainty(const Instrument& instrument, const Pose& pose,
                                            const Grid<double>& expected_per_sr) {
  if (!instrument.calibration || instrument.calibration->parameters.empty()) return std::nullopt;
  const SampleView view = sample_view(instrument, pose);
  const std::vector<ViewChange> changes = calibration_changes(instrument, pose);
  const int rows = expected_per_sr.rows(), columns = expected_per_sr.columns();
  Grid<float> out(rows, columns);
  tbb::parallel_for(0, (rows + kPoseTile - 1) / kPoseTile, [&](int band) {
    for (int c = 0; c < columns; c += kPoseTile) {
      const Tile tile{band * kPoseTile, std::min(rows, (band + 1) * kPoseTile), c, std::min(columns, c + kPoseTile)};
      if (!varies_slowly(view, tile)) {
        exact_tile(view, changes, tile, expected_per_sr, out);
        continue;
      }
      const TileForm form(view, changes, tile);
      const double per_row = tile.last_row - tile.first_row > 1 ? 1.0 / (tile.last_row - 1 - tile.first_row) : 0;
      for (int row = tile.first_row; row < tile.last_row; ++row)
        tile_row(form.row((row - tile.first_row) * per_row), tile, row, expected_per_sr, out);
    }
  });
  return out;
}

}  // namespace scatmap
