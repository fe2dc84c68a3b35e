#pragma once
#include <Eigen/Core>

#include "calib/target_model.h"

namespace scatmap::calib {

enum class Loss {
  kSquares,
  kCauchy,  ///< of each target's distance in standard deviations, scale 2: far targets lose their say, none its
            ///< gradient
};

struct SolveOptions {
  Loss loss = Loss::kSquares;
  int passes = 2;     ///< minimisations; before each the whitening is renewed at the values reached
  bool tight = true;  ///< last pass to rounding; false: to 1e-4 of the cost, enough to judge targets and parameters
};

struct Solution {
  Eigen::VectorXd values;  ///< of every parameter, m and rad
  Whitening whitening;     ///< that the last pass used
  double cost = 0;         ///< Σ squared whitened residuals and prior residuals (robust: Σ ρ)
  int iterations = 0;      ///< steps tried in all passes
  bool converged = false;
};

/// Least squares with Levenberg-Marquardt (Ceres), analytic derivatives and frozen weights per pass, so that the
/// parameter-dependent variance adds no bias. Priors of `set` are measurements.
/// @returns nothing if a used target's beam misses the detector plane at the start
std::optional<Solution> solve(const TargetModel& model, const Used& used, const FitSet& set,
                              const Eigen::VectorXd& start, const SolveOptions& options = {});

}  // namespace scatmap::calib
