#pragma once
#include <array>
#include <cstddef>

#include "scatmap/angles/opencv_lens.h"

namespace scatmap::kernel {

/// Columns first, first + step, ….
struct LensColumns {
  double first, step;
  std::size_t n;
};

/// Where Newton's method begins: x = x[0] + u (x[1] + u (…)), likewise y, u = first + i·step at the i-th column.
struct LensStart {
  double first, step;
  std::array<double, 5> x, y;
};

/// Newton's method along a row, a fixed number of steps: 4 from a far start, 2 from a near one (within some 1e-5), 1
/// from a close one (within some 1e-9). determinant: of d(x', y')/d(x, y) at the result, not positive where the image
/// has folded back; residual_px: how far the result projects from its pixel.
void run_unproject_far(const OpencvLens& lens, double row, const LensColumns& columns, const LensStart& start,
                       double* x, double* y, double* determinant, double* residual_px);
void run_unproject_near(const OpencvLens& lens, double row, const LensColumns& columns, const LensStart& start,
                        double* x, double* y, double* determinant, double* residual_px);
void run_unproject_close(const OpencvLens& lens, double row, const LensColumns& columns, const LensStart& start,
                         double* x, double* y, double* determinant, double* residual_px);
/// What a part of a row is judged by.
struct LensJudgement {
  bool met;          ///< all residuals at most `accepted_px` and all determinants positive; NaN is not
  double farthest2;  ///< largest x² + y² of those that are numbers
};
LensJudgement run_judge(std::size_t n, double accepted_px, const double* x, const double* y, const double* determinant,
                        const double* residual_px);

/// Both angles of matrix·(x, y, 1); `matrix` row by row.
void run_ray_angles(const double (&matrix)[9], std::size_t n, const double* x, const double* y, double* theta,
                    double* phi, double* z);

/// One step more from (x, y), for the pixels that need it. rounding_px: as far as a unit in the last places of x and y
/// moves the pixel.
struct LensStep {
  double x, y, determinant, residual_px;
  double rounding_px = 0;
};
LensStep newton_step(const OpencvLens& lens, double column, double row, double x, double y);

/// `determinant` at (x, y); not positive either where a denominator has passed 0.
double unfolded_at(const OpencvLens& lens, double x, double y);
/// Bounds from below of the lens's stretch in any direction at any point at n distances from the axis: the least
/// eigenvalue of its Jacobian's symmetric part. The lens is one to one on every disc where it is positive.
void run_least_stretch(const OpencvLens& lens, std::size_t n, const double* radius, double* stretch);

}  // namespace scatmap::kernel
