#pragma once
#include "scatmap/brdf/pose_tiles.h"

/// The vector loops of pose_tiles.cpp.
namespace scatmap {

/// Everything about one pixel that does not depend on which change acts.
struct PixelState {
  double row, column;
  double x, y, z;             ///< the ray, m
  double vx, vy, vz;          ///< its direction
  double ux, uy;              ///< slopes of the half vector u = to_source + v: ux/uz, uy/uz
  double per_r, per_r2;       ///< 1/|ray|, 1/|ray|²
  double per_uz;              ///< 1/uz
  double nx, ny, nz;          ///< the detector's normal
  double per_facing;          ///< 1/(normal · ray)
  double column_x, column_y;  ///< change of the half vector's slopes per column, over the determinant
  double row_x, row_y;
};
void fill_actions(const PixelState& p, const ChangeRows& changes, PoseActions& out);

/// Coefficients of the form along one row of a tile: a + t (b + t c), t = (column − first_column)·per_column.
struct RowForm {
  alignas(64) float a[8], b[8], c[8];
};

/// The row at t of a tile, 0 at its first row and 1 at its last.
void row_form(const PoseTiles::Tile& tile, double t, RowForm& out);

/// Columns from the first to the last of some kind; empty where first >= last.
struct ColumnSpan {
  int first, last;  ///< last: one past
};

/// Squares over [first_column, last_column) with central differences: NaN beside any NaN. @return where they are NaN
ColumnSpan form_squares(const RowForm& form, float per_column, const GradientRows& f, int first_column, int last_column,
                        float* out);

/// One square; t as above.
float form_square(const RowForm& form, float t, const Gradient& g);

/// u = sqrt(square).
void square_roots(int pixels, float* square);
/// u_pose = sqrt(square) in place, and sqrt(u_random² + square) to u_total.
void pose_and_total(int pixels, const float* u_random, float* square, float* u_total);

}  // namespace scatmap
