#pragma once
#include <cstddef>
#include <span>

#include "scatmap/model/tile.h"

namespace scatmap {

/// Largest difference between the sum of a tile's active terms and the cubic in column and row through their values at
/// four by four Chebyshev nodes, 1/sr. With x in [−1, 1] across the tile the nodes' polynomial is at most 1/8, and
/// 1.85 is the largest sum of the four basis polynomials.
double cubic_remainder_per_sr(const Curvature<4>& curvature, const Tile& tile);

enum class Fill { kAssign, kAdd };

/// Fills a tile with `terms.constant_per_sr` and that cubic, or adds them; `values` points at its first pixel, rows are
/// `stride` apart.
void fill_cubic(const TileTerms& terms, const ModelKernel& kernel, const DirectionPlane& plane, const Tile& tile,
                double* values, std::size_t stride, Fill how);

}  // namespace scatmap
