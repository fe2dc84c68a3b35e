#pragma once
#include <optional>
#include <vector>

#include "scatmap/compare/profile.h"

namespace scatmap {

/// One fringe of a comb, at its summit (exp(quadratic) fitted to the part above 60 % of it). Bilinear sampling takes up
/// to about (2/period_px)² of the height, as much again across a band as narrow as half a period: 1 % at 20 px.
struct FringeMaximum {
  int order = 0;  ///< counted from the pattern's centre, negative before it; never 0
  double offset_px = 0;
  double angle_deg = 0;  ///< between the summit's direction and the centre's, with the sign of offset_px
  double height_per_sr = 0;
  bool clear = true;  ///< beyond the reach of the specular lobe, which adds to the fringes near it
};

/// The comb of fringes along a profile.
struct FringeComb {
  std::vector<FringeMaximum> maxima;  ///< by offset
  int orders_before = 0;        ///< from the pattern's centre to the profile's first end, those under the lobe too
  int orders_after = 0;         ///< to its last end
  double spacing_px = 0;        ///< slope of a straight line through offset over order, clear maxima
  double spacing_sigma_px = 0;  ///< standard error of that slope, from the scatter about the line
  double spacing_deg = 0;       ///< the same of angle over order
  double spacing_sigma_deg = 0;
  double first_height_per_sr = 0;  ///< mean of the innermost clear maximum of each side
  double last_height_per_sr = 0;   ///< mean of the outermost maximum of each side
};

/// Summits along a profile: a rise, then a fall, each by more than five standard deviations of the two values it spans
/// and a quarter of the higher; so noise makes no fringe and a cut-off fringe at an end is not counted. Without
/// u_random only the quarter counts. The profile is smoothed by (1 2 1)/4 for this, not for the heights. NaN samples
/// are passed over. Orders are not set.
std::vector<FringeMaximum> find_maxima(const Profile& profile);

/// Counts the fringes of a profile whose origin is the pattern's centre. `lobe_px`: reach of the specular lobe there
/// (3 × Peak::radius_px), 0 if there is none. Orders follow from distances in units of the spacing, so an order hidden
/// under the lobe or a mask is counted.
/// nullopt with fewer than three clear maxima.
std::optional<FringeComb> find_fringes(const Profile& profile, double lobe_px);

}  // namespace scatmap
