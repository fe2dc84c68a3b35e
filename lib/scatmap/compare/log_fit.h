#pragma once
#include <Eigen/Core>
#include <optional>

namespace scatmap {

struct LogFit {
  Eigen::VectorXd coefficients;
  Eigen::MatrixXd covariance;  ///< of the coefficients; in units of the data only if sigma was
};

/// Fits f = exp(basis · c) to the values themselves, weighted by 1/sigma²: a generalised linear model with logarithmic
/// link, solved by reweighted least squares. Unlike a fit of ln f it takes values at or below zero and is not biased by
/// noise. Single values further than six robust deviations from the fit are left out.
/// `basis`: samples × coefficients, first column 1. `value` and `sigma` (> 0): one per sample, same unit.
/// nullopt if there are fewer samples than coefficients + 1, all values are ≤ 0 or the basis is singular.
std::optional<LogFit> fit_log_linear(const Eigen::MatrixXd& basis, const Eigen::VectorXd& value,
                                     const Eigen::VectorXd& sigma);

}  // namespace scatmap
