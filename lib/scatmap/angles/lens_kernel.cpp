#include "scatmap/angles/lens_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "scatmap/base/arctangent.h"

namespace scatmap::kernel {
namespace {

struct Distorted {
  double x, y;
  double xx, xy, yx, yy;  // derivatives
};

SCATMAP_INLINE Distorted distort(const OpencvLens& l, double x, double y) {
  const auto& k = l.k;
  const double r2 = x * x + y * y;
  const double top = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4])), bottom = 1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
  const double top_slope = k[0] + r2 * (2 * k[1] + r2 * 3 * k[4]),
               bottom_slope = k[5] + r2 * (2 * k[6] + r2 * 3 * k[7]);
  const double inverse = 1 / bottom, radial = top * inverse;
  const double slope = 2 * (top_slope - radial * bottom_slope) * inverse;  // d(radial)/dx = slope x
  const double prism_x = 2 * (k[8] + 2 * k[9] * r2), prism_y = 2 * (k[10] + 2 * k[11] * r2);
  Distorted d;
  d.x = x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x) + r2 * (k[8] + k[9] * r2);
  d.y = y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y + r2 * (k[10] + k[11] * r2);
  d.xx = radial + slope * x * x + 2 * k[2] * y + 6 * k[3] * x + prism_x * x;
  d.xy = slope * x * y + 2 * k[2] * x + 2 * k[3] * y + prism_x * y;
  d.yx = slope * x * y + 2 * k[2] * x + 2 * k[3] * y + prism_y * x;
  d.yy = radial + slope * y * y + 6 * k[2] * y + 2 * k[3] * x + prism_y * y;
  return d;
}

// The Jacobian's determinant, not positive where the image has folded back: there one of the eigenvalues is negative,
// or both.
SCATMAP_INLINE double unfolded(const Distorted& d) {
  const double determinant = d.xx * d.yy - d.xy * d.yx;
  return d.xx + d.yy > 0 ? determinant : -1;
}

SCATMAP_INLINE double at(const std::array<double, 5>& p, double u) {
  return p[0] + u * (p[1] + u * (p[2] + u * (p[3] + u * p[4])));
}

template <int Steps>
SCATMAP_INLINE void unproject(const OpencvLens& lens, double row, const LensColumns& columns, const LensStart& begin,
                              double* __restrict x_out, double* __restrict y_out, double* __restrict determinant,
                              double* __restrict residual_px) {
  const OpencvLens l = lens;  // copies: the results cannot alias them
  const LensStart start = begin;
  const double wanted_y = (row - l.cy) / l.fy;
  const double wanted_first = (columns.first - l.cx) / l.fx, wanted_step = columns.step / l.fx;
  for (std::size_t i = 0; i < columns.n; ++i) {
    const double c = static_cast<double>(static_cast<int>(i)), u = start.first + c * start.step;
    const double wanted_x = wanted_first + c * wanted_step;
    double x = at(start.x, u), y = at(start.y, u);
#pragma GCC unroll 4
    for (int step = 0; step < Steps; ++step) {
      const Distorted d = distort(l, x, y);
      const double ex = wanted_x - d.x, ey = wanted_y - d.y, inverse = 1 / (d.xx * d.yy - d.xy * d.yx);
      x += (d.yy * ex - d.xy * ey) * inverse;
      y += (d.xx * ey - d.yx * ex) * inverse;
    }
    const Distorted d = distort(l, x, y);
    const double ex = (wanted_x - d.x) * l.fx, ey = (wanted_y - d.y) * l.fy;
    x_out[i] = x;
    y_out[i] = y;
    determinant[i] = unfolded(d);
    residual_px[i] = std::sqrt(ex * ex + ey * ey);
  }
}

}  // namespace

SCATMAP_CLONES void run_unproject_far(const OpencvLens& lens, double row, const LensColumns& columns,
                                      const LensStart& start, double* x, double* y, double* determinant,
                                      double* residual_px) {
  unproject<4>(lens, row, columns, start, x, y, determinant, residual_px);
}
SCATMAP_CLONES void run_unproject_near(const OpencvLens& lens, double row, const LensColumns& columns,
                                       const LensStart& start, double* x, double* y, double* determinant,
                                       double* residual_px) {
  unproject<2>(lens, row, columns, start, x, y, determinant, residual_px);
}
SCATMAP_CLONES void run_unproject_close(const OpencvLens& lens, double row, const LensColumns& columns,
                                        const LensStart& start, double* x, double* y, double* determinant,
                                        double* residual_px) {
  unproject<1>(lens, row, columns, start, x, y, determinant, residual_px);
}

SCATMAP_CLONES LensJudgement run_judge(std::size_t n, double accepted_px, const double* x, const double* y,
                                       const double* determinant, const double* residual_px) {
  constexpr std::size_t kLanes = 16;  // maxima of their own: one after the other would take as long as the rays
  std::array<double, kLanes> most2{};
  std::array<std::int64_t, kLanes> missed{};
  const auto judge = [&](std::size_t i, std::size_t k) {
    const double r2 = x[i] * x[i] + y[i] * y[i];
    most2[k] = r2 > most2[k] ? r2 : most2[k];
    missed[k] |= (residual_px[i] <= accepted_px ? 0 : 1) | (determinant[i] > 0 ? 0 : 1);
  };
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    SCATMAP_INDEPENDENT
    for (std::size_t k = 0; k < kLanes; ++k) judge(i + k, k);
  }
  for (; i < n; ++i) judge(i, 0);
  LensJudgement out{true, 0};
  for (std::size_t k = 0; k < kLanes; ++k) {
    out.met = out.met && missed[k] == 0;
    out.farthest2 = std::max(out.farthest2, most2[k]);
  }
  return out;
}

SCATMAP_CLONES void run_ray_angles(const double (&matrix)[9], std::size_t n, const double* __restrict x,
                                   const double* __restrict y, double* __restrict theta, double* __restrict phi,
                                   double* __restrict z) {
  const double m0 = matrix[0], m1 = matrix[1], m2 = matrix[2], m3 = matrix[3], m4 = matrix[4], m5 = matrix[5],
               m6 = matrix[6], m7 = matrix[7], m8 = matrix[8];
  for (std::size_t i = 0; i < n; ++i) {
    const double a = m0 * x[i] + m1 * y[i] + m2, b = m3 * x[i] + m4 * y[i] + m5, c = m6 * x[i] + m7 * y[i] + m8;
    theta[i] = quadrant_arctangent<double>(std::sqrt(a * a + b * b), c).radians();
    phi[i] = azimuth_from_minus_x<double>(a, b);
    z[i] = c;
  }
}

LensStep newton_step(const OpencvLens& l, double column, double row, double x, double y) {
  const double wanted_x = (column - l.cx) / l.fx, wanted_y = (row - l.cy) / l.fy;
  const Distorted d = distort(l, x, y);
  const double ex = wanted_x - d.x, ey = wanted_y - d.y, inverse = 1 / (d.xx * d.yy - d.xy * d.yx);
  const double nx = x + (d.yy * ex - d.xy * ey) * inverse, ny = y + (d.xx * ey - d.yx * ex) * inverse;
  const Distorted at = distort(l, nx, ny);
  constexpr double kUnit = std::numeric_limits<double>::epsilon();
  const double rounding_x = kUnit * (std::abs(at.xx * nx) + std::abs(at.xy * ny)),
               rounding_y = kUnit * (std::abs(at.yx * nx) + std::abs(at.yy * ny));
  return {nx, ny, unfolded(at), std::hypot((wanted_x - at.x) * l.fx, (wanted_y - at.y) * l.fy),
          std::hypot(rounding_x * l.fx, rounding_y * l.fy)};
}

namespace {

double denominator(const OpencvLens& l, double r2) { return 1 + r2 * (l.k[5] + r2 * (l.k[6] + r2 * l.k[7])); }

}  // namespace

double unfolded_at(const OpencvLens& l, double x, double y) {
  return denominator(l, x * x + y * y) > 0 ? unfolded(distort(l, x, y)) : -1;
}

SCATMAP_CLONES void run_least_stretch(const OpencvLens& lens, std::size_t n, const double* __restrict radius,
                                      double* __restrict stretch) {
  OpencvLens radial = lens;
  constexpr std::array<std::size_t, 6> kOthers{2, 3, 8, 9, 10, 11};
  for (const std::size_t i : kOthers) radial.k[i] = 0;
  const double tangential = 6 * (std::abs(lens.k[2]) + std::abs(lens.k[3]));
  const double prism = 2 * std::abs(lens.k[8]) + 2 * std::abs(lens.k[10]),
               prism2 = 4 * std::abs(lens.k[9]) + 4 * std::abs(lens.k[11]);
  const double k4 = lens.k[5], k5 = lens.k[6], k6 = lens.k[7];
  for (std::size_t i = 0; i < n; ++i) {
    const double r = radius[i], r2 = r * r;
    const Distorted d = distort(radial, r, 0);
    const double least = (d.xx < d.yy ? d.xx : d.yy) - r * (tangential + prism + prism2 * r2);
    stretch[i] = 1 + r2 * (k4 + r2 * (k5 + r2 * k6)) > 0 ? least : -1;
  }
}

}  // namespace scatmap::kernel
