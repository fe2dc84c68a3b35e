#pragma once
#include <span>

#include "scatmap/angles/pixel_plane.h"

namespace scatmap {

/// Directions in sample axes, of any length, one in each place of three arrays of equal size.
struct DirectionSpans {
  std::span<const double> x, y, z;
};

/// Where pixel positions go: two arrays of the directions' size.
struct PixelSpans {
  std::span<double> column, row;
};

/// pixel_of_direction of many directions at once, in vector instructions; NaN where a direction never meets the front
/// or back of the detector plane (it is parallel, or points the other way, or is NaN). Allocates nothing.
/// Error: kInverseMaxError_rad of direction, for directions of pixels of the frame over its finest pixel step and times
/// its spread (FrameExtent). @param rows, columns of the frame: positions are computed from its middle
void pixels_of_directions(const SampleView& view, int rows, int columns, const DirectionSpans& directions,
                          const PixelSpans& out);

inline constexpr double kInverseMaxError_rad = 1e-15;

}  // namespace scatmap
