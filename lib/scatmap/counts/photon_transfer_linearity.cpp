#include "scatmap/counts/photon_transfer_linearity.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace scatmap {
namespace {

constexpr Eigen::Index kMostCoefficients = 3;

// 99 % point of F(1, degrees of freedom).
double f_99(Eigen::Index freedom) {
  constexpr std::array<double, 10> kTable{4052, 98.5, 34.1, 21.2, 16.3, 13.7, 12.2, 11.3, 10.6, 10.0};
  return kTable[static_cast<std::size_t>(std::clamp<Eigen::Index>(freedom, 1, 10) - 1)];
}

struct Solution {
  Eigen::VectorXd unknowns;    // a, then the coefficients in units of the range
  Eigen::MatrixXd covariance;  // for unit weights
  double chi_squared = 0;
  Eigen::VectorXd residual;  // relative
  Eigen::Index freedom = 0;
};

Solution solve(std::span<const LinearityPoint> points, double range, Eigen::Index coefficients) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd a(n, 1 + coefficients);
  Eigen::VectorXd y(n), u(n);
  double longest = 0;
  for (const LinearityPoint& p : points) longest = std::max(longest, p.exposure_s);
  for (Eigen::Index i = 0; i < n; ++i) {
    const LinearityPoint& p = points[static_cast<std::size_t>(i)];
    y[i] = p.moment[0] / range;
    u[i] = y[i] * std::hypot(p.u_relative, kLightStability);
    a(i, 0) = p.exposure_s / longest;
    for (Eigen::Index k = 0; k < coefficients; ++k)
      a(i, 1 + k) = -p.moment[static_cast<std::size_t>(k + 1)] / std::pow(range, static_cast<double>(k + 2));
  }
  const Eigen::VectorXd weight = u.cwiseInverse();
  const Eigen::MatrixXd weighted = weight.asDiagonal() * a;
  const Eigen::LDLT<Eigen::MatrixXd> normal(weighted.transpose() * weighted);
  Solution out;
  out.unknowns = normal.solve(weighted.transpose() * (weight.asDiagonal() * y));
  out.covariance = normal.solve(Eigen::MatrixXd::Identity(1 + coefficients, 1 + coefficients));
  const Eigen::VectorXd left = y - a * out.unknowns;
  out.chi_squared = left.cwiseQuotient(u).squaredNorm();
  out.residual = left.cwiseQuotient(a.col(0) * out.unknowns[0]);
  out.freedom = n - 1 - coefficients;
  return out;
}

// The fewest coefficients that no larger number improves on.
Eigen::Index needed(const std::vector<Solution>& by_count) {
  for (std::size_t few = 0; few < by_count.size(); ++few) {
    bool enough = true;
    for (std::size_t more = few + 1; more < by_count.size(); ++more) {
      const double gained = by_count[few].chi_squared - by_count[more].chi_squared;
      const double noise = by_count[more].chi_squared / static_cast<double>(by_count[more].freedom);
      enough = enough && gained / static_cast<double>(more - few) <= f_99(by_count[more].freedom) * noise;
    }
    if (enough) return static_cast<Eigen::Index>(few);
  }
  return static_cast<Eigen::Index>(by_count.size()) - 1;
}

// Of Σ c_k: the correction's relative change from no signal to full range.
double u_at_full(const Solution& s) {
  const Eigen::Index k = s.unknowns.size() - 1;
  const double scatter = std::max(1.0, s.chi_squared / static_cast<double>(s.freedom));
  return std::sqrt(scatter * s.covariance.bottomRightCorner(k, k).sum());
}

}  // namespace

double LinearityFit::left() const { return std::hypot(largest_residual, std::numbers::sqrt3 * u_full); }

std::optional<LinearityFit> fit_linearity(std::span<const LinearityPoint> points, double range_dn) {
  const auto n = static_cast<Eigen::Index>(points.size());
  if (n < 4) return std::nullopt;
  std::vector<Solution> by_count;
  for (Eigen::Index k = 0; k <= std::min(kMostCoefficients, n - 3); ++k) by_count.push_back(solve(points, range_dn, k));
  const Eigen::Index count = needed(by_count);
  const Solution& s = by_count[static_cast<std::size_t>(count)];
  LinearityFit out;
  for (Eigen::Index k = 0; k < count; ++k)
    out.coefficients.push_back(s.unknowns[1 + k] / std::pow(range_dn, static_cast<double>(k + 1)));
  out.largest_residual = s.residual.cwiseAbs().maxCoeff();
  // A coefficient too small to be seen may still be there.
  out.u_full = u_at_full(by_count[static_cast<std::size_t>(std::max<Eigen::Index>(1, count))]);
  return out;
}

}  // namespace scatmap
