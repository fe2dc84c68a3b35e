#pragma once
#include "scatmap/brdf/brdf_map.h"

namespace scatmap {

/// A map in three numbers.
struct MapSummary {
  std::size_t good = 0;        ///< pixels of mask 0
  double largest = -HUGE_VAL;  ///< BRDF among them, sr⁻¹
  double mean_relative = 0;    ///< of per_pixel_uncertainty() over the BRDF, where that is above 10 σ; NaN: nowhere
};
/// The same for any number of threads.
MapSummary summarise(const BrdfMap& map);

}  // namespace scatmap
