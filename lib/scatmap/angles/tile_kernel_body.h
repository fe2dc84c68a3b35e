#pragma once
#include <array>
#include <cmath>
#include <cstddef>

#include "scatmap/base/simd.h"

namespace scatmap::kernel {

inline constexpr int kTileDegree = 4;  ///< largest
inline constexpr int kTileRows = 32;

/// Taylor coefficients of both angles along each row of a tile, in columns from the tile's middle. The first is the
/// angle itself.
struct TileCoefficients {
  std::array<std::array<double, kTileRows>, kTileDegree + 1> theta, phi;
};

/// The tile's middle column: row i is at start + d row_step with d = first_d + i, in any unit of length.
struct TileLine {
  double first_d;
  double x, y, z;
  double x_down, y_down, z_down;  ///< from row to row
  double x_step, y_step, z_step;  ///< from column to column
};

/// Coefficients 1 to kTileDegree. With S = x² + y² and R = S + z² along the row, both quadratic in d,
/// phi' = (x y' − y x')/S and theta' = (n0 + n1 d)/(R sqrt(S)): products of power series.
SCATMAP_INLINE void tile_series(const TileLine& line, std::size_t rows, TileCoefficients& out) {
  for (std::size_t i = 0; i < rows; ++i) {
    const double e = line.first_d + static_cast<double>(static_cast<int>(i));
    const double x = line.x + e * line.x_down, y = line.y + e * line.y_down, z = line.z + e * line.z_down;
    const double s0 = x * x + y * y, s1 = 2 * (x * line.x_step + y * line.y_step),
                 s2 = line.x_step * line.x_step + line.y_step * line.y_step;
    const double r0 = s0 + z * z, r1 = s1 + 2 * z * line.z_step, r2 = s2 + line.z_step * line.z_step;
    const double root = std::sqrt(s0), inverse = 1 / (s0 * r0);
    const double a1 = s1 * r0 * inverse, a2 = s2 * r0 * inverse;  // S/s0 = 1 + a1 d + a2 d²
    const double b1 = r1 * s0 * inverse, b2 = r2 * s0 * inverse;
    // 1/S, 1/sqrt(S) and 1/R by their recurrences.
    const double f1 = -a1, f2 = -(a1 * f1 + a2), f3 = -(a1 * f2 + a2 * f1);
    const double g1 = -0.5 * a1, g2 = -0.5 * (1.5 * a1 * g1 + a2), g3 = -(2.5 * a1 * g2 + 2 * a2 * g1) * (1.0 / 3);
    const double h1 = -b1, h2 = -(b1 * h1 + b2), h3 = -(b1 * h2 + b2 * h1);
    const double m1 = g1 + h1, m2 = g2 + g1 * h1 + h2, m3 = g3 + g2 * h1 + g1 * h2 + h3;
    const double n0 = 0.5 * s1 * z - s0 * line.z_step, n1 = s2 * z - 0.5 * s1 * line.z_step;
    const double scale = root * inverse;  // 1/(r0 sqrt(s0))
    out.theta[1][i] = scale * n0;
    out.theta[2][i] = scale * (n0 * m1 + n1) * (1.0 / 2);
    out.theta[3][i] = scale * (n0 * m2 + n1 * m1) * (1.0 / 3);
    out.theta[4][i] = scale * (n0 * m3 + n1 * m2) * (1.0 / 4);
    const double turn = (x * line.y_step - y * line.x_step) * r0 * inverse;
    out.phi[1][i] = turn;
    out.phi[2][i] = turn * f1 * (1.0 / 2);
    out.phi[3][i] = turn * f2 * (1.0 / 3);
    out.phi[4][i] = turn * f3 * (1.0 / 4);
  }
}

/// One row of a tile: angle = angle + (c0 + c1 d + …), c0 the part of the angle that float32 loses.
struct RowPolynomial {
  float first_d;
  float theta, phi;
  std::array<float, kTileDegree + 1> theta_part, phi_part;
};

template <int Degree>
SCATMAP_INLINE void tile_row(const RowPolynomial& p, std::size_t n, float* theta, float* phi) {
  for (std::size_t i = 0; i < n; ++i) {
    const float d = p.first_d + static_cast<float>(static_cast<int>(i));
    float t = p.theta_part[Degree], f = p.phi_part[Degree];
    for (int k = Degree - 1; k >= 0; --k) {
      t = t * d + p.theta_part[static_cast<std::size_t>(k)];
      f = f * d + p.phi_part[static_cast<std::size_t>(k)];
    }
    theta[i] = p.theta + t;
    phi[i] = p.phi + f;
  }
}

}  // namespace scatmap::kernel
