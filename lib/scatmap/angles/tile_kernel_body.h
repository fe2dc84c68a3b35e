#pragma once
#include <array>
#include <cmath>
#include <cstddef>

#include "scatmap/base/simd.h"

namespace scatmap::kernel {

/// Largest and least degree: what float32 or double is worth.
template <class T>
inline constexpr int kTileDegree = 4;
template <>
inline constexpr int kTileDegree<double> = 10;
template <class T>
inline constexpr int kLeastTileDegree = 1;
template <>
inline constexpr int kLeastTileDegree<double> = 5;
inline constexpr int kTileRows = 32;

/// One number for every row of a tile: what vector instructions take.
using TileColumn = std::array<double, kTileRows>;

/// Taylor coefficients of both angles along each row of a tile, in columns from the tile's middle. The first are the
/// angles there, from those of the tile's middle.
template <int Degree>
struct TileCoefficients {
  std::array<TileColumn, Degree + 1> theta, phi;
};

/// The tile's middle column: row i is at start + d row_step with d = first_d + i, in any unit of length. Rows past
/// the tile's last are computed and not used.
struct TileLine {
  double first_d;
  double x, y, z;
  double x_down, y_down, z_down;  ///< from row to row
  double x_step, y_step, z_step;  ///< from column to column
};

/// Power series of (1 + p1 d + p2 d²)^exponent in every row: its recurrence.
template <std::size_t N>
SCATMAP_INLINE void power_series(const TileColumn& p1, const TileColumn& p2, double exponent,
                                 std::array<TileColumn, N>& c) {
  for (std::size_t i = 0; i < kTileRows; ++i) {
    c[0][i] = 1;
    c[1][i] = exponent * p1[i];
  }
  for (std::size_t k = 2; k < N; ++k) {
    const auto n = static_cast<double>(static_cast<int>(k));
    const double last = (exponent + 1 - n) / n, before = (2 * exponent + 2 - n) / n;
    for (std::size_t i = 0; i < kTileRows; ++i) c[k][i] = last * (p1[i] * c[k - 1][i]) + before * (p2[i] * c[k - 2][i]);
  }
}

/// Coefficients 1 to Degree of every row. With S = x² + y² and R = S + z² along the row, both quadratic in d,
/// phi' = (x y' − y x')/S and theta' = (n0 + n1 d)/(R sqrt(S)): products of power series.
template <int Degree>
SCATMAP_INLINE void tile_series(const TileLine& line, TileCoefficients<Degree>& out) {
  TileColumn s1, s2, r1, r2, n0, n1, turn;
  for (std::size_t i = 0; i < kTileRows; ++i) {
    const double e = line.first_d + static_cast<double>(static_cast<int>(i));
    const double x = line.x + e * line.x_down, y = line.y + e * line.y_down, z = line.z + e * line.z_down;
    const double along = x * line.x_step + y * line.y_step,
                 step2 = line.x_step * line.x_step + line.y_step * line.y_step;
    const double s0 = x * x + y * y, r0 = s0 + z * z, inverse = 1 / (s0 * r0);
    const double over_s0 = r0 * inverse, over_r0 = s0 * inverse, scale = std::sqrt(s0) * inverse;
    s1[i] = 2 * along * over_s0;
    s2[i] = step2 * over_s0;
    r1[i] = 2 * (along + z * line.z_step) * over_r0;
    r2[i] = (step2 + line.z_step * line.z_step) * over_r0;
    n0[i] = scale * (along * z - s0 * line.z_step);
    n1[i] = scale * (step2 * z - along * line.z_step);
    turn[i] = (x * line.y_step - y * line.x_step) * over_s0;
  }
  constexpr std::size_t kTerms = Degree;
  std::array<TileColumn, kTerms> f, g, h;
  power_series(s1, s2, -1, f);    // s0/S
  power_series(s1, s2, -0.5, g);  // sqrt(s0/S)
  power_series(r1, r2, -1, h);    // r0/R
  TileColumn before{};            // coefficient of g h
  for (std::size_t k = 0; k < kTerms; ++k) {
    TileColumn product{};
    for (std::size_t j = 0; j <= k; ++j) {
      for (std::size_t i = 0; i < kTileRows; ++i) product[i] += g[j][i] * h[k - j][i];
    }
    const double share = 1.0 / static_cast<double>(static_cast<int>(k + 1));
    for (std::size_t i = 0; i < kTileRows; ++i) {
      out.theta[k + 1][i] = (n0[i] * product[i] + n1[i] * before[i]) * share;
      out.phi[k + 1][i] = turn[i] * f[k][i] * share;
    }
    before = product;
  }
}

/// One row of a tile: angle = angle + (c0 + c1 d + …), c0 the part of the angle that T loses.
template <class T>
struct RowPolynomial {
  T first_d;
  T theta, phi;
  std::array<T, kTileDegree<T> + 1> theta_part, phi_part;
};

template <int Degree, class T>
SCATMAP_INLINE void tile_row(const RowPolynomial<T>& p, std::size_t n, T* theta, T* phi) {
  for (std::size_t i = 0; i < n; ++i) {
    const T d = p.first_d + static_cast<T>(static_cast<int>(i));
    T t = p.theta_part[Degree], f = p.phi_part[Degree];
    for (int k = Degree - 1; k >= 0; --k) {
      t = t * d + p.theta_part[static_cast<std::size_t>(k)];
      f = f * d + p.phi_part[static_cast<std::size_t>(k)];
    }
    theta[i] = p.theta + t;
    phi[i] = p.phi + f;
  }
}

}  // namespace scatmap::kernel
