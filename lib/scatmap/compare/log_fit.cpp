#include "scatmap/compare/log_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace scatmap {
namespace {

constexpr double kStartFloor = 0.05;  // of the highest value: where the first logarithms are cut
constexpr double kOutlierDeviations = 6;
constexpr int kIterations = 12;
constexpr double kLargestStep = 1;  // in ln f per iteration, against overshoot from a poor start

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// 1 for samples that agree with the fit, 0 for outliers.
Eigen::ArrayXd agreement(const Eigen::ArrayXd& deviation) {
  std::vector<double> magnitude(static_cast<std::size_t>(deviation.size()));
  Eigen::Map<Eigen::ArrayXd>(magnitude.data(), deviation.size()) = deviation.abs();
  const double spread = std::max(1.0, 1.4826 * median_of(magnitude));
  return (deviation.abs() <= kOutlierDeviations * spread).cast<double>();
}

}  // namespace

std::optional<LogFit> fit_log_linear(const Eigen::MatrixXd& basis, const Eigen::VectorXd& value,
                                     const Eigen::VectorXd& sigma) {
  if (basis.rows() <= basis.cols()) return std::nullopt;
  const double highest = value.maxCoeff();
  if (!(highest > 0)) return std::nullopt;
  Eigen::ArrayXd fitted = value.array().max(kStartFloor * highest);
  Eigen::ArrayXd target = fitted.log();
  Eigen::ArrayXd used = Eigen::ArrayXd::Ones(value.size());
  Eigen::VectorXd coefficients;
  Eigen::LDLT<Eigen::MatrixXd> normal;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::ArrayXd weight = used * (fitted / sigma.array()).square();
    const Eigen::MatrixXd weighted = weight.matrix().asDiagonal() * basis;
    normal.compute(basis.transpose() * weighted);
    if (normal.info() != Eigen::Success || normal.rcond() < 1e-14) return std::nullopt;
    coefficients = normal.solve(weighted.transpose() * target.matrix());
    const Eigen::ArrayXd log_fitted = (basis * coefficients).array();
    fitted = log_fitted.exp();
    if (!coefficients.allFinite() || !fitted.allFinite()) return std::nullopt;
    target = log_fitted + ((value.array() - fitted) / fitted).max(-kLargestStep).min(kLargestStep);
    used = agreement((value.array() - fitted) / sigma.array());
  }
  const Eigen::Index n = basis.cols();
  return LogFit{coefficients, normal.solve(Eigen::MatrixXd::Identity(n, n))};
}

}  // namespace scatmap
