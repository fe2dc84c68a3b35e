#pragma once
#include <cstddef>

#include "scatmap/model/tile.h"

namespace scatmap {

/// The `culled` method on one tile of a frame: values within `tolerance` of the model. The tile is halved again and
/// again; in each part a term that cannot matter is left out, one that hardly varies is a constant, and where all that
/// is left is smooth it is a cubic in column and row. All three by bounds that hold for every pixel (tile.h); what
/// remains is computed as the `vector` method does. NaN below the horizon.
/// `values` points at the frame's pixel (0, 0), rows are `stride` apart.
void culled_tile(const ModelKernel& kernel, const DirectionPlane& plane, const ModelTolerance& tolerance,
                 const Tile& tile, double* values, std::size_t stride);

}  // namespace scatmap
