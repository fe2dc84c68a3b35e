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

/// Indices from the first to the last of some kind; empty where first >= last.
struct Span {
  int first, last;  ///< last: one past
};

/// u_pose of a tile's row by central differences: NaN beside any NaN. @return where it is NaN
Span form_row(const RowForm& form, float per_column, const GradientRows& f, int pixels, const PoseRow& out);

/// One square; t as above.
float form_square(const RowForm& form, float t, const Gradient& g);

}  // namespace scatmap
