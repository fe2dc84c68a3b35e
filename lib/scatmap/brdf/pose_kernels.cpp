#include "scatmap/brdf/pose_kernels.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "scatmap/base/simd.h"

namespace scatmap {

SCATMAP_CLONES void fill_actions(const PixelState& state, const ChangeRows& changes, PoseActions& out) {
  const PixelState p = state;
  const auto at = [&](std::size_t number) { return changes.row(number); };
  const double *ox = at(0), *oy = at(1), *oz = at(2), *cx = at(3), *cy = at(4), *cz = at(5), *rx = at(6), *ry = at(7),
               *rz = at(8), *nx = at(9), *ny = at(10), *nz = at(11), *bx = at(12), *by = at(13), *bz = at(14),
               *ln_area = at(15);
  double *relative = out.relative.data(), *columns = out.columns.data(), *rows = out.rows.data();
  const auto n = static_cast<int>(changes.size());
  SCATMAP_INDEPENDENT
  for (int k = 0; k < n; ++k) {
    const double dx = ox[k] + p.column * cx[k] + p.row * rx[k], dy = oy[k] + p.column * cy[k] + p.row * ry[k],
                 dz = oz[k] + p.column * cz[k] + p.row * rz[k];
    const double along = (p.x * dx + p.y * dy + p.z * dz) * p.per_r2;
    const double facing = nx[k] * p.x + ny[k] * p.y + nz[k] * p.z + p.nx * dx + p.ny * dy + p.nz * dz;
    relative[k] = ln_area[k] + facing * p.per_facing + dz / p.z - 4 * along;
    // The direction's change, then that of the half vector's slopes.
    const double v = p.vx * dx + p.vy * dy + p.vz * dz;
    const double ux = (dx - p.vx * v) * p.per_r + bx[k], uy = (dy - p.vy * v) * p.per_r + by[k],
                 uz = (dz - p.vz * v) * p.per_r + bz[k];
    const double sx = (ux - p.ux * uz) * p.per_uz, sy = (uy - p.uy * uz) * p.per_uz;
    columns[k] = sx * p.row_y - sy * p.row_x;
    rows[k] = p.column_x * sy - p.column_y * sx;
  }
}

SCATMAP_CLONES void row_form(const PoseTiles::Tile& tile, double t, RowForm& out) {
  alignas(64) double node[3][8];
  for (int j = 0; j < 3; ++j) {
    for (int k = 0; k < 8; ++k) node[j][k] = tile.a[j][k] + t * (tile.b[j][k] + t * tile.c[j][k]);
  }
  for (int k = 0; k < 8; ++k) {
    out.a[k] = static_cast<float>(node[0][k]);
    out.b[k] = static_cast<float>(4 * node[1][k] - 3 * node[0][k] - node[2][k]);
    out.c[k] = static_cast<float>(2 * (node[0][k] - 2 * node[1][k] + node[2][k]));
  }
}

namespace {

SCATMAP_INLINE float coefficient(const RowForm& q, int k, float t) { return q.a[k] + t * (q.b[k] + t * q.c[k]); }

// In float: the tile's own error is a thousand times its rounding.
SCATMAP_INLINE float square_of(const RowForm& q, float t, float f, float x, float y) {
  const float s = f * (f * coefficient(q, 0, t) + x * coefficient(q, 1, t) + y * coefficient(q, 2, t)) +
                  x * (x * coefficient(q, 3, t) + y * coefficient(q, 4, t)) + y * y * coefficient(q, 5, t);
  return 0 > s ? 0 : s;  // rounding may leave a hair below 0; NaN stays
}

// The form in whole differences between neighbours, which are twice the slopes. Powers of two: nothing is rounded.
SCATMAP_INLINE RowForm of_differences(const RowForm& form) {
  constexpr float kShare[8] = {1, 0.5f, 0.5f, 0.25f, 0.25f, 0.25f, 1, 1};
  RowForm q;
  for (int k = 0; k < 8; ++k) {
    q.a[k] = form.a[k] * kShare[k];
    q.b[k] = form.b[k] * kShare[k];
    q.c[k] = form.c[k] * kShare[k];
  }
  return q;
}

// From the first to the last NaN.
SCATMAP_INLINE Span absent_span(const float* u, int n) {
  int first = n, last = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const bool absent = u[i] != u[i];
    const int from = absent ? i : n, past = absent ? i + 1 : 0;
    first = from < first ? from : first;
    last = past > last ? past : last;
  }
  return {first, last};
}

// @return largest bit pattern of a square: NaN is past infinity
template <bool kTotal>
SCATMAP_INLINE std::int32_t fill(const RowForm& q, float per_column, const GradientRows& f, int n, const PoseRow& out) {
  const double *above = f.above, *here = f.here, *below = f.below;
  const float* u_random = out.u_random;
  float *u_pose = out.u_pose, *u_total = out.u_total;
  std::int32_t largest = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const auto x = static_cast<float>(here[i + 1] - here[i - 1]), y = static_cast<float>(below[i] - above[i]);
    const float square = square_of(q, static_cast<float>(i) * per_column, static_cast<float>(here[i]), x, y);
    u_pose[i] = std::sqrt(square);
    if constexpr (kTotal) u_total[i] = std::sqrt(u_random[i] * u_random[i] + square);
    const std::int32_t bits = std::bit_cast<std::int32_t>(square) & 0x7fffffff;
    largest = bits > largest ? bits : largest;
  }
  return largest;
}

}  // namespace

float form_square(const RowForm& form, float t, const Gradient& g) {
  return square_of(form, t, static_cast<float>(g.f), static_cast<float>(g.per_column), static_cast<float>(g.per_row));
}

SCATMAP_CLONES Span form_row(const RowForm& form, float per_column, const GradientRows& f, int pixels,
                             const PoseRow& out) {
  const RowForm q = of_differences(form);  // and a local copy: nothing that `out` could overlap
  const std::int32_t largest =
      out.u_total != nullptr ? fill<true>(q, per_column, f, pixels, out) : fill<false>(q, per_column, f, pixels, out);
  constexpr std::int32_t kInfinite = 0x7f800000;
  return largest > kInfinite ? absent_span(out.u_pose, pixels) : Span{pixels, pixels};
}

}  // namespace scatmap
