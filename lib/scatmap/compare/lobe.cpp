#include "scatmap/compare/lobe.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "scatmap/compare/log_fit.h"

namespace scatmap {
namespace {

constexpr double kCore = 0.5;  // of the summit
constexpr std::size_t kFewestPixels = 9;
constexpr int kRefinements = 5;

// ln f = c0 + c1 x + c2 y + c3 x² + c4 x y + c5 y² around a pixel.
using Quadratic = Eigen::Matrix<double, 6, 1>;

Quadratic basis_at(double x, double y) { return (Quadratic() << 1, x, y, x * x, x * y, y * y).finished(); }

struct Summit {
  Eigen::Vector2d at;
  Eigen::Matrix2d inverse_hessian;
  double height = 0;
  Eigen::Vector2d radii;  // 1/e: long, short
};

std::optional<Summit> summit_of(const Quadratic& c) {
  Eigen::Matrix2d hessian;
  hessian << 2 * c[3], c[4], c[4], 2 * c[5];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(hessian);
  if (!(axes.eigenvalues().maxCoeff() < 0)) return std::nullopt;
  Summit s;
  s.inverse_hessian = hessian.inverse();
  s.at = -s.inverse_hessian * Eigen::Vector2d(c[1], c[2]);
  s.height = std::exp(basis_at(s.at.x(), s.at.y()).dot(c));
  // ln f falls by 1 where −½ h r² = −1.
  s.radii = {std::sqrt(-2 / axes.eigenvalues()[1]), std::sqrt(-2 / axes.eigenvalues()[0])};
  return s;
}

// Distance from the start to half height: median of eight directions, bad pixels passed over.
double half_height_distance(const BrdfMap& map, int column, int row, double height) {
  std::array<double, 8> distance{};
  for (std::size_t k = 0; k < 8; ++k) {
    const double angle = static_cast<double>(k) * std::numbers::pi / 4;
    double reach = 1;
    for (;; ++reach) {
      const int c = column + static_cast<int>(std::lround(reach * std::cos(angle)));
      const int r = row + static_cast<int>(std::lround(reach * std::sin(angle)));
      if (c < 0 || r < 0 || c >= map.mask.columns() || r >= map.mask.rows()) break;
      if (is_good(map, r, c) && map.brdf_per_sr(r, c) < kCore * height) break;
    }
    distance[k] = reach;
  }
  std::nth_element(distance.begin(), distance.begin() + 4, distance.end());
  return distance[4];
}

// Good pixels of a square around the start where keep(x, y) holds, as a fit problem.
template <class Keep>
std::optional<LogFit> fit_where(const BrdfMap& map, int column, int row, int reach, const Keep& keep) {
  std::vector<Quadratic> rows;
  std::vector<double> value, sigma;
  for (int r = std::max(0, row - reach); r <= std::min(map.mask.rows() - 1, row + reach); ++r) {
    for (int c = std::max(0, column - reach); c <= std::min(map.mask.columns() - 1, column + reach); ++c) {
      if (!is_good(map, r, c) || !keep(c - column, r - row)) continue;
      const double u = map.u_random_per_sr.empty() ? 1 : static_cast<double>(map.u_random_per_sr(r, c));
      if (!(u > 0)) continue;
      rows.push_back(basis_at(c - column, r - row));
      value.push_back(map.brdf_per_sr(r, c));
      sigma.push_back(u);
    }
  }
  if (rows.size() < kFewestPixels) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd basis(n, 6);
  for (Eigen::Index i = 0; i < n; ++i) basis.row(i) = rows[static_cast<std::size_t>(i)].transpose();
  return fit_log_linear(basis, Eigen::Map<Eigen::VectorXd>(value.data(), n),
                        Eigen::Map<Eigen::VectorXd>(sigma.data(), n));
}

Lobe describe(const LogFit& fit, const Summit& s, int column, int row, bool has_noise) {
  Lobe lobe{.summit = {column + s.at.x(), row + s.at.y()},
            .height_per_sr = s.height,
            .radius_px = s.radii[0],
            .minor_radius_px = s.radii[1]};
  if (!has_noise) return lobe;
  // d summit = −H⁻¹ (dg + dH·summit); at the summit d ln height = basis · dc.
  const double x = s.at.x(), y = s.at.y();
  Eigen::Matrix<double, 2, 6> gradient;
  gradient << 0, 1, 0, 2 * x, y, 0,  //
      0, 0, 1, 0, x, 2 * y;
  const Eigen::Matrix<double, 2, 6> jacobian = -s.inverse_hessian * gradient;
  const Eigen::Matrix2d covariance = jacobian * fit.covariance * jacobian.transpose();
  lobe.column_sigma_px = std::sqrt(covariance(0, 0));
  lobe.row_sigma_px = std::sqrt(covariance(1, 1));
  const Quadratic at = basis_at(x, y);
  lobe.height_sigma_per_sr = s.height * std::sqrt(at.dot(fit.covariance * at));
  return lobe;
}

}  // namespace

std::optional<Lobe> fit_lobe(const BrdfMap& map, int column, int row, double height_per_sr) {
  const double half = half_height_distance(map, column, row, height_per_sr);
  const double start_radius = std::max(2.0, half);
  const int reach = static_cast<int>(std::ceil(2.5 * start_radius));
  std::optional<LogFit> fit =
      fit_where(map, column, row, reach, [&](int x, int y) { return std::hypot(x, y) <= start_radius; });
  std::optional<Summit> summit;
  for (int i = 0; i <= kRefinements; ++i) {
    if (!fit) return std::nullopt;
    summit = summit_of(fit->coefficients);
    if (!summit || !(summit->at.norm() <= reach)) return std::nullopt;
    if (i == kRefinements) break;
    const Quadratic c = fit->coefficients;
    const double core = std::log(kCore * summit->height);
    fit = fit_where(map, column, row, reach, [&](int x, int y) { return basis_at(x, y).dot(c) >= core; });
  }
  return describe(*fit, *summit, column, row, !map.u_random_per_sr.empty());
}

}  // namespace scatmap
