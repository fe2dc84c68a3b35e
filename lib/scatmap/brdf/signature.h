#pragma once
#include <optional>

#include "scatmap/counts/reduce.h"

namespace scatmap {

/// The beam signature: the straight-through beam summed over its whole spot, background removed.
struct Signature {
  double rate_dn_per_s = 0;        ///< sum over the aperture
  double u_rate_dn_per_s = 0;      ///< shot, read and dark noise, background, replaced pixels
  double column = 0, row = 0;      ///< centroid
  double radius_px = 0;            ///< of the aperture
  double background_dn_per_s = 0;  ///< per pixel
  double effective_rate = 0;       ///< Σ rate²/Σ rate: the level at which a non-linear pixel works, DN/s
  int replaced_pixels = 0;         ///< hot or bad pixels in the aperture, taken as the mean of their good neighbours
};

/// Aperture radius in units of the beam's second-moment radius (2σ, ISO 11146): a Gaussian leaves exp(−18) outside.
inline constexpr double kApertureBeamRadii = 3;

/// The background is measured in a ring from the aperture out to here.
constexpr double background_radius_px(double aperture_radius_px) { return 1.5 * aperture_radius_px + 5; }

/// Finds the spot, its centroid and second-moment radius (iterated in the aperture), the background in a surrounding
/// ring, and sums. `radius_px` overrides the aperture.
/// @throws Error if a pixel of the aperture is saturated, no spot stands out of the noise by 20 sigma, or the aperture
///         leaves the frame
Signature measure_signature(const Counts& counts, std::optional<double> radius_px);

/// Light beside the beam: the brightest mean of 3 × 3 pixels beyond the background ring.
struct OtherSpot {
  double column, row;
  double share;  ///< of the beam's peak, if that is a Gaussian's: twice effective_rate
};
/// @return nothing if it is below kLeastOtherSpot of the peak, does not stand 20 sigma out of the noise, or is one
/// pixel's
std::optional<OtherSpot> other_spot(const Counts& counts, const Signature& beam);
inline constexpr double kLeastOtherSpot = 0.01;

}  // namespace scatmap
