#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "scatmap/frame/frame.h"

namespace scatmap {

/// Frames of one exposure time under constant uniform light, and their darks.
struct TransferLevel {
  double exposure_s = 0;
  std::span<const Frame> flats;  ///< two or more
  std::span<const Frame> darks;  ///< two or more
};

/// One level's point on the photon-transfer curve. Temporal variances come from differences of pairs of frames.
struct TransferPoint {
  double exposure_s = 0;
  double mean_dn = 0, variance_dn2 = 0;            ///< of the flats
  double dark_mean_dn = 0, dark_variance_dn2 = 0;  ///< of the darks
  double u_variance_dn2 = 0;                       ///< of variance − dark variance
  double saturated = 0;                            ///< share of the flats' values at or above saturation
  bool used = false;                               ///< in the fit of the gain
};

struct Estimate {
  double value = 0;
  double u = 0;  ///< standard uncertainty
};

/// A sensor characterised as EMVA 1288 release 3.1 names its numbers.
struct PhotonTransfer {
  std::vector<TransferPoint> points;  ///< ascending exposure
  Estimate gain_dn_per_e;  ///< K: slope of variance against mean, both above dark and linearised, up to 70 % of
                           ///< saturation
  Estimate dark_noise_e;   ///< sigma_d: temporal, without quantisation, at the shortest exposure
  std::optional<double> saturation_dn;  ///< see photon_transfer; absent if the variance never fell
  Estimate dark_current_e_per_s;        ///< slope of the mean dark over exposure
  Estimate bias_dn;                     ///< mean dark at no exposure: with two exposure times, u is noise alone
  std::size_t left_out_pixels = 0;      ///< see kDefectSigmas
  Estimate dsnu_e;                      ///< DSNU1288: spatial standard deviation of the dark signal
  Estimate prnu;                        ///< PRNU1288: relative, at the level nearest half of saturation
  std::optional<Estimate>
      linearity_error;  ///< LE: mean relative deviation from the straight line, 5 to 95 % of saturation
  std::optional<double> largest_deviation;  ///< the largest of them
  std::vector<double> linearity;            ///< SensorModel::linearity that makes the flats proportional to time
  std::optional<double> nonlinearity_left;  ///< relative half width, between any two levels, with `linearity` applied
  double chi_squared = 0;                   ///< per degree of freedom of the gain's fit
};

/// A converter's ceiling is seen where at least this share of a bright flat's values is one and the same, ...
inline constexpr double kCeilingShare = 0.5;
/// ... and counts are good up to this many standard deviations of one frame's noise below it: higher, noise is cut.
inline constexpr double kCeilingSigmas = 4;
/// A level with more saturated values is left out of the linearity.
inline constexpr double kMostSaturated = 1e-3;

/// Pixels whose dark at no exposure, from the shortest and the longest, is so many robust standard deviations (of 1 DN
/// or more) off the median count nowhere: stuck columns would shift every level.
inline constexpr double kDefectSigmas = 50;

/// Characterises a sensor from its frames. Means and variances: temporal_noise.h. Saturation is the converter's ceiling less
/// kCeilingSigmas where flats reach it; else (a full well) the mean at which the variance is largest, as EMVA 1288 has
/// it.  The slow variation of the light over the frame (a quadratic surface) is taken out of PRNU. Spatial numbers
/// leave out pixels further than 6 robust standard deviations from the median.
/// @param nominal_saturation_dn used where the frames do not reach saturation
/// @param stated_saturation_dn used whatever the frames show, and becomes the result's saturation_dn
/// @throws Error for a stated saturation that most levels' flats reach in the mean, or beyond the converter's ceiling,
/// for fewer than two flats or darks at a level, fewer than two usable levels, frames of different shapes, flats that
/// do not grow with the exposure time, or a variance that does not grow with the signal
PhotonTransfer photon_transfer(std::span<const TransferLevel> levels, std::optional<double> nominal_saturation_dn,
                               std::optional<double> stated_saturation_dn = std::nullopt);

}  // namespace scatmap
