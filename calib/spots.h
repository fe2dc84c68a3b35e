#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "calib/spots_gaussian.h"
#include "calib/spots_image.h"

namespace scatmap::calib {

/// What is unusual about a spot; bits combine.
using SpotFlags = std::uint16_t;
inline constexpr SpotFlags kSpotSaturated = 1u << 0;  ///< saturated pixels in it were left out of the fit
inline constexpr SpotFlags kSpotClipped = 1u << 1;    ///< the frame's edge lies within 3 standard deviations
inline constexpr SpotFlags kSpotElongated = 1u << 2;  ///< longer than kElongation times its width
inline constexpr SpotFlags kSpotNeighbour = 1u << 3;  ///< fitted together with another spot
inline constexpr SpotFlags kSpotNarrow = 1u
                                         << 4;  ///< narrower than 0.6 px: the Gaussian's shape within a pixel matters
inline constexpr SpotFlags kSpotMisfit = 1u << 5;     ///< no Gaussian; the model's error entered its covariance
inline constexpr SpotFlags kSpotSecondary = 1u << 6;  ///< not the strongest of its frame
inline constexpr SpotFlags kSpotFaint = 1u << 7;      ///< flux below 12 sigma, where sigma is up to 10 % too small

struct SpotFlag {
  SpotFlags bit;
  const char* name;
  const char* meaning;
};
/// Every flag, in bit order; the meanings complete "the spot ...".
inline constexpr std::array<SpotFlag, 8> kSpotFlags{{
    {kSpotSaturated, "saturated", "has saturated pixels, which were left out"},
    {kSpotClipped, "clipped", "is cut by the frame's edge"},
    {kSpotElongated, "elongated", "is elongated"},
    {kSpotNeighbour, "neighbour", "overlaps another spot and was fitted together with it"},
    {kSpotNarrow, "narrow", "is narrower than 0.6 px"},
    {kSpotMisfit, "misfit", "is no Gaussian; its sigma allows for that"},
    {kSpotSecondary, "secondary", "is not the strongest of its frame"},
    {kSpotFaint, "faint", "is faint; its sigma may be 10 % too small"},
}};

inline constexpr double kElongation = 1.5;

enum class SpotMethod {
  kMaximumLikelihood,  ///< Gaussian fit: efficient where the light is Gaussian
  kMoments,            ///< windowed centroid: no assumption on the shape, larger sigma
};

struct Spot {
  double column_px = 0;  ///< centroid; pixel centres are integers
  double row_px = 0;
  Eigen::Matrix2d covariance_px2;  ///< of the centroid
  double flux_e = 0;
  double u_flux_e = 0;
  SpotAxes axes{};          ///< fitted standard deviations and orientation
  double background_e = 0;  ///< per pixel, above the dark
  double chi2 = 0;          ///< of the Gaussian fit, all spots fitted together
  int degrees_of_freedom = 0;
  SpotFlags flags = 0;

  /// One number for both axes: root mean square of the two standard uncertainties.
  double sigma_px() const;
};

struct SpotsInFrame {
  std::vector<Spot> spots;           ///< strongest first; empty when nothing stands out
  std::size_t hot_pixels = 0;        ///< found by their shape, beyond those the darks show
  std::vector<std::string> dropped;  ///< candidates that are no spots, in words
};

/// Finds the specular spots of a frame and their centroids. Candidates narrower than a spot can be are dropped as hot
/// pixels, candidates whose fit fails or whose flux is below five sigma are dropped and named. Where the background lies
/// below the dark, the dark is too high, and shot noise counts from the background. A misfit that a second spot within
/// two standard deviations would explain, though not how the two share the light, widens sigma to span both.
SpotsInFrame find_spots(SpotImage image, SpotMethod method);

}  // namespace scatmap::calib
