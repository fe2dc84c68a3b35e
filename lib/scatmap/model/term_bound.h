#pragma once
#include <array>

#include "scatmap/model/direction_plane.h"
#include "scatmap/model/interval_series.h"
#include "scatmap/model/model_kernel.h"

namespace scatmap {

/// Pixel positions [low, high] in columns and in rows, ends included; fractional ones too.
struct PixelRange {
  Interval columns;
  Interval rows;
};

/// What a series runs along: its variable is the column (or the row) in pixels.
enum class Along { kColumns, kRows };

/// Directions of all pixels of a range: scattered and summed with the incident one, sample axes.
template <int N>
struct RangeDirections {
  std::array<Series<N>, 3> ws;
  std::array<Series<N>, 3> sum;
};

template <int N>
RangeDirections<N> range_directions(const DirectionPlane& plane, const Vector3<double>& wi, const PixelRange& range,
                                    Along along);

/// Value (N = 0), and Taylor coefficients along a row or column, of one term all over a range of pixels: rigorous
/// bounds by interval arithmetic on the term's own formula. Everything where a bound does not exist or was not found:
/// a coefficient at a tilted facet's horizon, along the normal, at the critical angle.
template <int N>
Series<N> term_series(const ModelKernel::Term& term, const RangeDirections<N>& directions);

extern template RangeDirections<0> range_directions(const DirectionPlane&, const Vector3<double>&, const PixelRange&,
                                                    Along);
extern template RangeDirections<4> range_directions(const DirectionPlane&, const Vector3<double>&, const PixelRange&,
                                                    Along);
extern template RangeDirections<8> range_directions(const DirectionPlane&, const Vector3<double>&, const PixelRange&,
                                                    Along);
extern template Series<0> term_series(const ModelKernel::Term&, const RangeDirections<0>&);
extern template Series<4> term_series(const ModelKernel::Term&, const RangeDirections<4>&);
extern template Series<8> term_series(const ModelKernel::Term&, const RangeDirections<8>&);

}  // namespace scatmap
