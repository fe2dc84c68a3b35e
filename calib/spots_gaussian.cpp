#include "calib/spots_gaussian.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <utility>

namespace scatmap::calib {
namespace {

struct Quadrature {
  double narrowest_px;                           // used from this width upwards
  std::vector<std::pair<double, double>> nodes;  // on [-1/2, 1/2]; weights sum to 1
};

// Gauss-Legendre rules of 1, 2, 3, 4 and 6 nodes (Abramowitz and Stegun, table 25.4), scaled to a unit interval.
const std::vector<Quadrature>& quadratures() {
  static const std::vector<Quadrature> kRules{
      {8.0, {{0, 1}}},
      {2.5, {{-0.2886751345948129, 0.5}, {0.2886751345948129, 0.5}}},
      {1.0, {{-0.3872983346207417, 5.0 / 18}, {0, 8.0 / 18}, {0.3872983346207417, 5.0 / 18}}},
      {0.7,
       {{-0.4305681557970263, 0.1739274225687269},
        {-0.1699905217924282, 0.3260725774312731},
        {0.1699905217924282, 0.3260725774312731},
        {0.4305681557970263, 0.1739274225687269}}},
      {0.0,
       {{-0.4662347571015760, 0.0856622461895852},
        {-0.3306046932331323, 0.1803807865240693},
        {-0.1193095930415985, 0.2339569672863455},
        {0.1193095930415985, 0.2339569672863455},
        {0.3306046932331323, 0.1803807865240693},
        {0.4662347571015760, 0.0856622461895852}}}};
  return kRules;
}

}  // namespace

Eigen::Matrix2d GaussianSpot::covariance_px2() const {
  Eigen::Matrix2d l;
  l << column_sd_px, 0, shear_px, row_sd_px;
  return l * l.transpose();
}

double GaussianSpot::distance2(double column, double row) const {
  const double u = (column - column_px) / column_sd_px;
  const double v = (row - row_px - shear_px * u) / row_sd_px;
  return u * u + v * v;
}

GaussianSpot gaussian_spot(double column_px, double row_px, double flux_e, const Eigen::Matrix2d& covariance_px2) {
  const double column_sd = std::sqrt(covariance_px2(0, 0));
  const double shear = covariance_px2(1, 0) / column_sd;
  return {column_px, row_px, flux_e, column_sd, shear, std::sqrt(covariance_px2(1, 1) - shear * shear)};
}

SpotAxes spot_axes(const GaussianSpot& spot) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spot.covariance_px2());
  const Eigen::Vector2d axis = solver.eigenvectors().col(1);
  double angle = std::atan2(axis.y(), axis.x());
  if (angle > std::numbers::pi / 2) angle -= std::numbers::pi;
  if (angle <= -std::numbers::pi / 2) angle += std::numbers::pi;
  return {std::sqrt(solver.eigenvalues()(1)), std::sqrt(solver.eigenvalues()(0)), angle};
}

PixelGaussian::PixelGaussian(const GaussianSpot& spot)
    : spot_(spot), density_(spot.flux_e / (2 * std::numbers::pi * spot.column_sd_px * spot.row_sd_px)) {
  const double narrowest = spot_axes(spot).minor_px;
  const Quadrature* rule = &quadratures().back();
  for (const Quadrature& q : quadratures()) {
    if (narrowest >= q.narrowest_px) {
      rule = &q;
      break;
    }
  }
  for (const auto& [x, wx] : rule->nodes) {
    for (const auto& [y, wy] : rule->nodes) nodes_.push_back({x, y, wx * wy});
  }
  const double reach = 9 + 1 / narrowest;  // exp(−81/2) is below 1e-17
  far2_ = reach * reach;
}

PixelExpectation PixelGaussian::at(int column, int row) const {
  PixelExpectation out;
  if (!(spot_.distance2(column, row) < far2_)) return out;
  const double a = spot_.column_sd_px, b = spot_.shear_px, d = spot_.row_sd_px;
  for (const auto& [x, y, weight] : nodes_) {
    const double u = (column + x - spot_.column_px) / a;
    const double v = (row + y - spot_.row_px - b * u) / d;
    const double e = weight * density_ * std::exp(-0.5 * (u * u + v * v));
    out.value_e += e;
    out.gradient[kColumn] += e * (u - v * b / d) / a;
    out.gradient[kRow] += e * v / d;
    out.gradient[kLogColumnSd] += e * (u * u - v * b * u / d - 1);
    out.gradient[kShear] += e * u * v / d;
    out.gradient[kLogRowSd] += e * (v * v - 1);
  }
  out.gradient[kLogFlux] = out.value_e;
  return out;
}

}  // namespace scatmap::calib
