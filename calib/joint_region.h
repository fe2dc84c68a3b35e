#pragma once
#include <Eigen/Core>

#include "calib/calibrate.h"

namespace scatmap::calib {

/// By how much chi², of the used targets and the priors together, is larger at some values than at the best fit of
/// everything that is not held. The joint region of all parameters: values for which this stays below the quantile of
/// chi² with result.set.size() degrees of freedom (likelihood ratio; Wilks).
///
/// Not the ellipsoid of the covariance: within the tolerances the valley of the best fit is curved (products of half a
/// degree and half a degree are pixels, its floor is hundredths of a pixel wide), so the ellipsoid is too thin along
/// one combination of parameters and holds the truth in 68 to 88 of 100 cases instead of 95. Single parameters and
/// directions of pixels are not concerned: their own intervals hold. Measured in tests/calib/monte_carlo.h.
///
/// @param values of the whole table, m and rad, as result.values
/// @throws Error if a used target's beam misses the detector at `values`
double joint_chi2(const TargetList& list, const CalibrationResult& result, const Eigen::VectorXd& values);

}  // namespace scatmap::calib
