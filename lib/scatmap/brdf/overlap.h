#pragma once
#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "scatmap/brdf/exposure_causes.h"
#include "scatmap/brdf/merge.h"

namespace scatmap {

/// Exposures that show the same light, the sample's or the beam's: only these can be compared.
struct OverlapGroup {
  std::span<const ScaledCounts> exposures;  ///< with nominal factors
  std::span<const double> level_per_unit;   ///< share of the linear range per map unit, likewise (0: no non-linearity)
};

/// Two exposures compared on the pixels that are good in both.
struct OverlapPair {
  std::size_t a = 0, b = 0;     ///< exposures, a < b, counted through all groups
  double ln_ratio = 0;          ///< ln of (a's value / b's value) with the final factors: what the solution leaves
  double u = 0;                 ///< standard uncertainty of ln_ratio, counting noise
  double pixels = 0;            ///< that carry weight
  double chi_squared = 0;       ///< per pixel: 1 when the two differ by noise alone
  double level_difference = 0;  ///< ln_ratio of the brighter half of the signal minus that of the dimmer half
  double u_level_difference = 0;
  bool used = true;     ///< false: reported and left out
  std::string problem;  ///< why, in words; empty when consistent
};

/// "exposures 1 and 3", "signature exposures 1 and 2".
std::string pair_name(const OverlapPair& pair, std::size_t sample_exposures);

/// Measured factors of all exposures: nominal × exp(sensitivity · shift).
struct OverlapSolution {
  Eigen::VectorXd shift;       ///< of each cause, in its unit
  Eigen::MatrixXd covariance;  ///< of the causes after the measurement and, last, of the pixel non-linearity (1)
  std::vector<OverlapPair> pairs;
};

/// A pair must measure its ratio to this, or it is not used; no ratio is trusted to better than kBestRatio.
inline constexpr double kWorstUsefulRatio = 0.05;
inline constexpr double kBestRatio = 2e-5;
/// A pair is inconsistent beyond this many standard deviations of any of its three tests (chi-squared, bright against
/// dim part, loop closure), ...
inline constexpr double kOverlapSigmas = 5;
/// ... and beyond these allowances for what is no fault: chi-squared per pixel, ratio.
inline constexpr double kChiSquaredAllowance = 0.25;
inline constexpr double kRatioAllowance = 5e-4;

/// Transmittance ratios from overlapping exposures, with the exposure-time ratio as ruler. For each pair the ratio is
/// Σ w x_a / Σ w x_b over jointly good pixels, w = μ/variance(x_a − x_b), with μ predicted from the *neighbours* of the
/// pixel in the merged map: a weight that knew the pixel's own noise would bias the ratio. Its noise and the level at
/// which its pixels work are summed at the pixels' own merged values. All pairs (with their covariance: they share
/// exposures) update the stated causes (filters, exposure times, laser, linearity) as one least-squares problem; stated
/// tolerances are normal priors of the same standard deviation. Merging and solving are iterated. Pairs that fail a
/// test are left out of the solution, so that what depends on them stays as uncertain as it was stated.
///
/// Ratios within several groups tell of the same causes: a filter that only the signature uses is measured there. A
/// master dark that two groups share is taken as independent between them: their light falls on different pixels.
///
/// @param groups the sample's exposures, then (if several) the signature's: the rows of causes.all_rows(), in order
/// @param u_nonlinearity  relative standard uncertainty at full range
OverlapSolution solve_overlap(std::span<const OverlapGroup> groups, const ExposureCauses& causes,
                              double u_nonlinearity);

}  // namespace scatmap
