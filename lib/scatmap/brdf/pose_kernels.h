#pragma once
#include "scatmap/brdf/pose_tiles.h"

/// The vector loops of pose_tiles.cpp.
namespace scatmap {

/// Coefficients of the form along one row of a tile: a + t (b + t c), t = (column − first_column)·per_column.
struct RowForm {
  alignas(64) double a[8], b[8], c[8];
};

/// The row at t of a tile, 0 at its first row and 1 at its last.
void row_form(const PoseTiles::Tile& tile, double t, RowForm& out);

/// Squares over [first_column, last_column) with central differences: NaN beside any NaN. @return whether any is NaN
bool form_squares(const RowForm& form, double per_column, const GradientRows& f, int first_column, int last_column,
                  float* out);

/// One square; t as above.
double form_square(const RowForm& form, double t, const Gradient& g);

/// u = sqrt(square).
void square_roots(int pixels, float* square);
/// u_pose = sqrt(square) in place, and sqrt(u_random² + square) to u_total.
void pose_and_total(int pixels, const float* u_random, float* square, float* u_total);

}  // namespace scatmap
