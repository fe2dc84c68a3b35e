#pragma once
#include <vector>

#include "calib/spots_gaussian.h"
#include "calib/spots_image.h"

namespace scatmap::calib {

/// Where a spot may be, before any fit.
struct SpotCandidate {
  GaussianSpot start;       ///< from the moments of its pixels
  double peak_sigmas = 0;   ///< height of the smoothed peak above the background, in its own noise
  double height_e = 0;      ///< the same, electrons per pixel
  double saturated_px = 0;  ///< pixels of it at saturation
};

/// A candidate's smoothed peak stands this far above the background.
inline constexpr double kDetectionSigmas = 6;
/// Two peaks are two spots when the saddle between them lies below the lower one by this share of its height, and by
/// kSaddleSigmas of noise. Two equal round Gaussians show two peaks from 3.3
/// standard deviations on; closer ones are left to the fit (spots.cpp).
inline constexpr double kSaddleShare = 0.25;
inline constexpr double kSaddleSigmas = 5;
/// A secondary spot below this share of the strongest one's height is not listed.
inline constexpr double kSecondaryShare = 0.01;

/// Finds candidates, strongest (most electrons) first. The image is smoothed by a Gaussian of 1 px, wider when
/// nothing stands out at 1 px or when the brightest spot is wide, and its peaks are separated by the depth of the
/// saddles between them.
std::vector<SpotCandidate> detect_spots(const SpotImage& image);

}  // namespace scatmap::calib
