#pragma once
#include "scatmap/angles/pixel_plane.h"

namespace scatmap {

/// Where a frame's pixels can lie on the sphere, and how fine they are: upper and lower bounds, no pixel is looked at.
struct FrameExtent {
  double theta_min_rad = 0;
  double theta_max_rad = 0;  ///< at most pi/2: what is beyond has no numbers
  double phi_max_rad = 0;
  bool off_seam = false;      ///< no pixel within 1e-6 rad of phi = 0
  double radius_rad = 0;      ///< largest angle from the frame's middle
  double nearest_m = 0;       ///< distance from the spot of the nearest point of the frame
  double spread = 1;          ///< farthest over nearest distance: rounding of pixel positions counts so much more
  double pixel_step_rad = 0;  ///< smallest change of direction from one pixel to the next, along any line
};

FrameExtent frame_extent(const SampleView& view, int rows, int columns);

/// Bounds of the methods on a frame, rad: their constants times its spread.
double exact_bound_rad(const FrameExtent& extent);
double vector_bound_rad(const FrameExtent& extent);

/// Bound of the `single` method on this frame: rounding of the largest theta and phi in it to float32, and arithmetic.
double single_bound_rad(const FrameExtent& extent, const SampleView& view, int columns);
/// The part of `linear`'s that is not the map's: the same, with the arithmetic of any place.
double linear_rounding_rad(const FrameExtent& extent);

}  // namespace scatmap
