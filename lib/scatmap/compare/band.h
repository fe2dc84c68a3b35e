#pragma once
#include <array>
#include <optional>
#include <vector>

#include "scatmap/compare/features.h"
#include "scatmap/compare/profile.h"

namespace scatmap {

/// The band of a fringe comb: a line of bright pixels through a specular peak, straight or bent.
struct Band {
  std::size_t peak = 0;      ///< index of the peak it passes through
  PixelPosition centre{};    ///< that peak
  double axis_deg = 0;       ///< tangent at the peak, from +columns towards +rows, in [−45, 135)
  double direction_deg = 0;  ///< the same in the scatter hemisphere: from growing theta_s in-plane towards +y
  double concentration = 0;  ///< resultant of the doubled position angles of its pixels: 1 a thin line, 0 no direction
  double radius_px = 0;      ///< across: from the ridge to 1/e of it
  double chord_deg = 0;      ///< the straight line the bend is measured from, as axis_deg
  double length_px = 1;      ///< scale of the bend's argument
  std::array<double, 5> bend{};  ///< px across = Σ bend[k] (along / length_px)^k
  double first_px = 0;           ///< along the chord: where the ridge was seen; beyond it goes on straight
  double last_px = 0;

  /// Ridge at a distance along the chord from the centre, px.
  PixelPosition at(double along_px) const;
};

/// Finds the band and follows its ridge. Direction first: second moments of the pixels' position angles about each
/// peak, weighted by the logarithm of their BRDF, clipped, with the lobes and what does not stand out of its
/// neighbourhood left out; the band belongs to the peak about which it is most aligned. With `axis_deg` given, the
/// moments choose only the peak. Then the ridge: centroids across the band in steps along it, joined by a polynomial of
/// up to fourth degree. nullopt if there is no peak or nothing line-shaped through one. @throws Error from sample_view
std::optional<Band> find_band(const BrdfMap& map, const std::vector<Peak>& peaks,
                              std::optional<double> axis_deg = std::nullopt);

/// BRDF along the ridge from edge to edge, one sample per pixel length.
Profile ridge_profile(const BrdfMap& map, const Band& band);

}  // namespace scatmap
