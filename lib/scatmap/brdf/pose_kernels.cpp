#include "scatmap/brdf/pose_kernels.h"

#include <cmath>

#include "scatmap/base/simd.h"

namespace scatmap {

SCATMAP_CLONES void row_form(const PoseTiles::Tile& tile, double t, RowForm& out) {
  alignas(64) double node[3][8];
  for (int j = 0; j < 3; ++j) {
    for (int k = 0; k < 8; ++k) node[j][k] = tile.a[j][k] + t * (tile.b[j][k] + t * tile.c[j][k]);
  }
  for (int k = 0; k < 8; ++k) {
    out.a[k] = node[0][k];
    out.b[k] = 4 * node[1][k] - 3 * node[0][k] - node[2][k];
    out.c[k] = 2 * (node[0][k] - 2 * node[1][k] + node[2][k]);
  }
}

namespace {

SCATMAP_INLINE double coefficient(const RowForm& q, int k, double t) { return q.a[k] + t * (q.b[k] + t * q.c[k]); }

SCATMAP_INLINE double square_of(const RowForm& q, double t, double f, double x, double y) {
  return f * (f * coefficient(q, 0, t) + x * coefficient(q, 1, t) + y * coefficient(q, 2, t)) +
         x * (x * coefficient(q, 3, t) + y * coefficient(q, 4, t)) + y * y * coefficient(q, 5, t);
}

}  // namespace

double form_square(const RowForm& form, double t, const Gradient& g) {
  return square_of(form, t, g.f, g.per_column, g.per_row);
}

SCATMAP_CLONES bool form_squares(const RowForm& form, double per_column, const GradientRows& f, int first_column,
                                 int last_column, float* out) {
  const RowForm q = form;  // a local copy: nothing that `out` could overlap
  const int n = last_column - first_column;
  const double *above = f.above + first_column, *here = f.here + first_column, *below = f.below + first_column;
  float* to = out + first_column;
  int any = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const double s =
        square_of(q, i * per_column, here[i], 0.5 * (here[i + 1] - here[i - 1]), 0.5 * (below[i] - above[i]));
    to[i] = static_cast<float>(s > 0 ? s : 0 * s);  // rounding may leave a hair below 0; NaN stays
  }
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) any |= to[i] != to[i] ? 1 : 0;
  return any != 0;
}

SCATMAP_CLONES void square_roots(int pixels, float* square) {
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) square[i] = std::sqrt(square[i]);
}

SCATMAP_CLONES void pose_and_total(int pixels, const float* u_random, float* square, float* u_total) {
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) {
    const float s = square[i];
    u_total[i] = std::sqrt(u_random[i] * u_random[i] + s);
    square[i] = std::sqrt(s);
  }
}

}  // namespace scatmap
