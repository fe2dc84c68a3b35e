#pragma once
#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "scatmap/brdf/exposure_causes.h"
#include "scatmap/brdf/merge.h"

namespace scatmap {

/// Two exposures compared on the pixels that are good in both.
struct OverlapPair {
  std::size_t a = 0, b = 0;     ///< exposures, a < b
  double ln_ratio = 0;          ///< ln of (a's value / b's value) with the final factors: what the solution leaves
  double u = 0;                 ///< standard uncertainty of ln_ratio, counting noise
  double pixels = 0;            ///< that carry weight
  double chi_squared = 0;       ///< per pixel: 1 when the two differ by noise alone
  double level_difference = 0;  ///< ln_ratio of the brighter half of the signal minus that of the dimmer half
  double u_level_difference = 0;
  bool used = true;     ///< false: reported and left out
  std::string problem;  ///< why, in words; empty when consistent
};

/// Measured factors of all exposures: nominal × exp(sensitivity · shift).
struct OverlapSolution {
  Eigen::VectorXd shift;       ///< of each cause, in its unit
  Eigen::MatrixXd covariance;  ///< of the causes after the measurement and, last, of the pixel non-linearity (1)
  std::vector<OverlapPair> pairs;
  double factor(const ExposureCauses& causes, std::size_t exposure) const;  ///< exp(sensitivity · shift)
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
/// pixel in the merged map: a weight that knew the pixel's own noise would bias the ratio. All pairs (with their
/// covariance: they share exposures) update the stated causes (filters, exposure times, laser, linearity) as one
/// least-squares problem; stated tolerances are normal priors of the same standard deviation. Merging and solving are
/// iterated. Pairs that fail a test are left out of the solution, so that what depends on them stays as uncertain as it
/// was stated.
///
/// @param exposures with nominal factors; two or more
/// @param level_per_unit  per exposure: share of the linear range per map unit (0: no non-linearity)
/// @param u_nonlinearity  relative standard uncertainty at full range
OverlapSolution solve_overlap(std::span<const ScaledCounts> exposures, const ExposureCauses& causes,
                              std::span<const double> level_per_unit, double u_nonlinearity);

}  // namespace scatmap
