#pragma once
#include <cstddef>

#include "scatmap/angles/opencv_lens.h"

namespace scatmap::kernel {

/// Newton's method from the distorted position, a fixed number of steps, for columns first, first + 1, …
/// determinant: of d(x', y')/d(x, y) at the result, not positive where the image has folded back; residual_px: how far
/// the result projects from its pixel.
void run_unproject(const OpencvLens& lens, double row, double first_column, std::size_t n, double* x, double* y,
                   double* determinant, double* residual_px);
/// Both angles of matrix·(x, y, 1); `matrix` row by row.
void run_ray_angles(const double (&matrix)[9], std::size_t n, const double* x, const double* y, double* theta,
                    double* phi, double* z);

/// One step more from (x, y), for the pixels that need it.
struct LensStep {
  double x, y, determinant, residual_px;
};
LensStep newton_step(const OpencvLens& lens, double column, double row, double x, double y);

}  // namespace scatmap::kernel
