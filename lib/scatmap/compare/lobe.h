#pragma once
#include <cmath>
#include <optional>

#include "scatmap/brdf/brdf_map.h"

namespace scatmap {

/// Summit of exp(quadratic) fitted to a lobe's core. Sigmas are 0 for a map without u_random.
struct Lobe {
  PixelPosition summit;
  double column_sigma_px = 0;
  double row_sigma_px = 0;
  double height_per_sr = 0;
  double height_sigma_per_sr = 0;
  double radius_px = 0;        ///< 1/e of the height, long axis
  double minor_radius_px = 0;  ///< short axis
};

/// Fits the lobe whose highest pixel is near (column, row) and about `height_per_sr` high. The core is where the fit
/// itself, not the noisy pixel, is above half height: choosing pixels by their values would raise the summit. nullopt
/// if the core has fewer than nine good pixels or no summit near the start.
std::optional<Lobe> fit_lobe(const BrdfMap& map, int column, int row, double height_per_sr);

/// The pixel's mask is 0 and its value finite.
inline bool is_good(const BrdfMap& map, int row, int column) {
  return map.mask(row, column) == 0 && std::isfinite(map.brdf_per_sr(row, column));
}

}  // namespace scatmap
