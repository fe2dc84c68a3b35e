#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "scatmap/brdf/merge.h"

namespace scatmap {

/// What the pixels say about the pairs of exposures, for one set of factors.
struct PairSums {
  Eigen::VectorXd ln_ratio;    ///< per pair: ln(Σ w x_a / Σ w x_b); NaN where there is no common pixel
  Eigen::MatrixXd covariance;  ///< between pairs, counting noise
  Eigen::VectorXd level;       ///< weighted mean difference of the levels of a and b, in linear ranges
  Eigen::VectorXd pixels, chi_squared;
  Eigen::VectorXd level_difference, u_level_difference;  ///< bright minus dim half, see OverlapPair
};

struct PairIndex {
  std::size_t a, b;
};

/// @param merged  of the same exposures with the same factors; value and mask are read
/// @param margin  per pair: relative difference that is no outlier yet, beside 6 sigma of noise
PairSums pair_sums(std::span<const ScaledCounts> exposures, const Merged& merged, std::span<const PairIndex> pairs,
                   std::span<const double> level_per_unit, double u_nonlinearity, const Eigen::VectorXd& margin);

}  // namespace scatmap
