#pragma once
#include <vector>

#include "scatmap/brdf/brdf_map.h"

namespace scatmap {

/// A specular peak: an isolated lobe. Standard uncertainties come from u_random alone and are 0 for a map without it.
struct Peak {
  double column_px = 0;  ///< of the lobe's summit, sub-pixel
  double row_px = 0;
  double column_sigma_px = 0;
  double row_sigma_px = 0;
  double height_per_sr = 0;  ///< of the summit, with whatever lies under the lobe
  double height_sigma_per_sr = 0;
  double radius_px = 0;        ///< from the summit to 1/e of it along the lobe's long axis
  double minor_radius_px = 0;  ///< along its short axis
  double theta_s_deg = 0;
  double phi_s_deg = 0;
  double prominence = 0;  ///< summit over the highest separate maximum that is no specular peak (a fringe, noise)

  PixelPosition position() const { return {column_px, row_px}; }
};

/// Most specular peaks a map may have. As many equally high maxima or more are a comb, not peaks.
inline constexpr int kMaxPeaks = 4;
/// A specular peak stands at least this factor above every maximum that is not one.
inline constexpr double kMinProminence = 2.5;

/// The specular peaks of a map, highest first; none if no lobe stands out.
/// A lobe is a maximum of the 3 × 3 median (so a single bright pixel is none, and lobes narrower than about 3 px are
/// not seen) that a valley of half its height divides from every higher one. Of the lobes, ordered by height, the first
/// n ≤ kMaxPeaks are peaks, n being the last rank that is followed by a step of kMinProminence: fringes of one comb are
/// alike and fall on the low side together. Position and height are those of exp(quadratic) fitted to the pixels above
/// half height (fit_log_linear). Masked and non-finite pixels are ignored.
/// @throws Error from sample_view
std::vector<Peak> find_peaks(const BrdfMap& map);

struct PeakPair {
  Peak measured;
  Peak modelled;
  double distance_px = 0;   ///< between the summits
  double angle_deg = 0;     ///< between their directions
  double height_ratio = 0;  ///< measured / modelled
};

/// Nearest neighbours first, each peak at most once; peaks without partner are in no pair. In the order of `measured`.
std::vector<PeakPair> pair_peaks(const std::vector<Peak>& measured, const std::vector<Peak>& modelled);

}  // namespace scatmap
