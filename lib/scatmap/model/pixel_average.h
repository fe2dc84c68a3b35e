#pragma once
#include <cstddef>

#include "scatmap/model/tile.h"

namespace scatmap {

/// The mean of the model over each pixel's square (pitch by pitch, evenly weighted) instead of its value at the centre:
/// what a coarse or binned sensor sees of fringes and narrow lobes. Within `tolerance` of the mean:
/// - where the second derivatives are bounded so that mean and centre cannot differ by more, the centre's value;
/// - elsewhere Gauss points, two by two or four by four in each of k by k parts of the pixel, k from bounds on the
///   fourth and eighth derivatives;
/// - where there is no such bound (along the normal, at the critical angle or a facet's horizon; features far narrower
///   than a part), parts of two by two points, and k doubles until two results agree to a tenth of the tolerance,
///   kLargestParts at most. This last criterion is tested, not proven.
/// NaN where the pixel's centre is below the horizon. Within eight pixels of it: eight by eight points, those below
/// count as 0, and no error is stated.
/// `values` points at the frame's pixel (0, 0), rows are `stride` apart.
void pixel_average_tile(const ModelKernel& kernel, const DirectionPlane& plane, const ModelTolerance& tolerance,
                        const Tile& tile, double* values, std::size_t stride);

inline constexpr int kLargestParts = 128;

}  // namespace scatmap
