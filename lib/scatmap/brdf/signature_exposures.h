#pragma once
#include <optional>
#include <span>
#include <vector>

#include "scatmap/brdf/merge.h"
#include "scatmap/brdf/signature.h"

namespace scatmap {

/// The beam as all signature exposures show it together.
struct MergedSignature {
  Signature beam;              ///< in DN/s as the first exposure shows it
  std::vector<double> share;   ///< of each exposure in the sum over the aperture; they add to 1
  double level_dn = 0;         ///< counts at which the pixels worked that carry the sum, for their non-linearity
  double outside = 0;          ///< with a stated aperture: share of the beam found that it leaves out
  double found_radius_px = 0;  ///< of that beam's aperture
  std::optional<OtherSpot> other = std::nullopt;  ///< light beside the beam
};

/// Merges the exposures of the beam like those of the sample (merge.h), so that a core that one saturates comes from
/// another, and sums the spot. One exposure: measure_signature as it is.
/// @param exposures one or more; factors relative to the first, whose own is 1
/// @throws Error as measure_signature; a pixel is saturated when no exposure shows it
MergedSignature merge_signature(std::span<const ScaledCounts> exposures, std::optional<double> radius_px);

}  // namespace scatmap
