#pragma once
#include <vector>

#include "scatmap/brdf/brdf_map.h"

namespace scatmap {

/// BRDF along a line of a map. All vectors have one entry per sample, except u_random_per_sr, which is empty if the
/// map has none. A sample that touches a masked or non-finite pixel is NaN.
struct Profile {
  std::vector<PixelPosition> position;
  std::vector<double> offset_px;  ///< length of the line from the origin, negative before it
  std::vector<double> angle_deg;  ///< between the sample's direction and the origin's, with the sign of offset_px
  std::vector<double> value_per_sr;
  std::vector<double> u_random_per_sr;

  std::size_t size() const { return position.size(); }
};

/// The whole pixel column nearest the origin, no interpolation; offsets grow with the row (paper, Figs. 2b and 8b).
/// @throws Error if the origin is off the map; from sample_view
Profile column_profile(const BrdfMap& map, PixelPosition origin);
/// The whole pixel row nearest the origin; offsets grow with the column.
Profile row_profile(const BrdfMap& map, PixelPosition origin);
/// The straight line through the origin, one bilinear sample per pixel length, from edge to edge.
/// `axis_deg` turns from +columns towards +rows; offsets grow along it.
Profile line_profile(const BrdfMap& map, PixelPosition origin, double axis_deg);
/// Bilinear samples at given positions in order; offsets are summed along the path, 0 at the position nearest the
/// origin. @throws Error if there is no position; from sample_view
Profile path_profile(const BrdfMap& map, PixelPosition origin, std::vector<PixelPosition> path);

struct Sample {
  double value_per_sr;
  double u_random_per_sr;  ///< NaN if the map has none
};

/// Bilinear between the four pixels around a position; both NaN off the map or where a pixel with a part in it is not
/// good.
Sample sample_map(const BrdfMap& map, PixelPosition at);

}  // namespace scatmap
