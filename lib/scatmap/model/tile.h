#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "scatmap/model/model_kernel.h"
#include "scatmap/model/term_bound.h"

namespace scatmap {

/// Pixels [column, column + columns) × [row, row + rows).
struct Tile {
  int column, row, columns, rows;

  PixelRange range(double margin = 0) const {
    return {{column - margin, column + columns - 1 + margin}, {row - margin, row + rows - 1 + margin}};
  }
  int area() const { return columns * rows; }
};

/// How far a value may be off: `relative` times the larger of the value itself and kPeakShare of the peak.
struct ModelTolerance {
  double relative;
  double peak_per_sr;  ///< at most the model's largest pixel value
};

/// Values below this share of the peak are held to an absolute error.
inline constexpr double kPeakShare = 1e-6;

/// What is left to compute in a tile: the terms whose own values matter, and what stands for the others. Made for the
/// whole frame, narrowed from tile to tile within it.
struct TileTerms {
  std::vector<std::size_t> active;  ///< indices into ModelKernel::terms()
  std::vector<Interval> values;     ///< of the active ones, in the tile
  double constant_per_sr = 0;       ///< of the Lambertian terms and of those that vary too little to be computed
  double spent_per_sr = 0;          ///< bound on the error made so far
  double floor_per_sr = 0;          ///< no value in the tile is smaller
  Interval cos_theta_s;

  double allowed_per_sr(const ModelTolerance& tolerance) const {
    return tolerance.relative * std::max(floor_per_sr, kPeakShare * tolerance.peak_per_sr);
  }
};

/// All terms, nothing known.
TileTerms all_terms(const ModelKernel& kernel);

/// Bounds the active terms over the tile (widened by `margin` pixels on all sides) and drops those that cannot matter
/// there: a term whose bound fits into what is left of `share` of the tolerance becomes 0, one that varies by no more
/// than that becomes a constant. Rigorous: no pixel's error grows by more than what is added to spent_per_sr.
TileTerms narrowed(const TileTerms& terms, const ModelKernel& kernel, const DirectionPlane& plane, const Tile& tile,
                   double margin, const ModelTolerance& tolerance, double share);

/// Bounds on the k-th Taylor coefficients of the sum of the active terms, per pixel^k, over the tile widened by
/// `margin`: along the columns, along the rows, or both together. Infinite where there is no bound.
template <int N>
struct Curvature {
  std::array<double, N + 1> columns{}, rows{};

  double both(std::size_t k) const { return columns[k] + rows[k]; }
};
template <int N>
Curvature<N> curvature(const TileTerms& terms, const ModelKernel& kernel, const DirectionPlane& plane, const Tile& tile,
                       double margin);
extern template Curvature<4> curvature<4>(const TileTerms&, const ModelKernel&, const DirectionPlane&, const Tile&,
                                          double);
extern template Curvature<8> curvature<8>(const TileTerms&, const ModelKernel&, const DirectionPlane&, const Tile&,
                                          double);

/// A lower bound of the largest pixel value of a frame: the largest of some pixels, among them those nearest to each
/// term's specular direction. 0 if all are NaN.
double peak_floor(const ModelKernel& kernel, const DirectionPlane& plane, int rows, int columns);

}  // namespace scatmap
