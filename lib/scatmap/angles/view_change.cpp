#include "scatmap/angles/view_change.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <string>

namespace scatmap {
namespace {

// Central difference over ±1e-3 of a file unit (µm, mdeg): truncation and rounding both stay below 1e-8 relative.
ViewChange derivative(const Instrument& instrument, const Pose& pose, const GeometryKey& key) {
  constexpr double kStep = 1e-3;
  Instrument plus = instrument, minus = instrument;
  plus.geometry.*key.member += kStep * key.unit;
  minus.geometry.*key.member -= kStep * key.unit;
  const SampleView a = sample_view(plus, pose), b = sample_view(minus, pose);
  const double inverse = 1 / (2 * kStep);
  return {(a.origin - b.origin) * inverse,       (a.column_step - b.column_step) * inverse,
          (a.row_step - b.row_step) * inverse,   (a.detector_normal - b.detector_normal) * inverse,
          (a.to_source - b.to_source) * inverse, std::log(a.pixel_area_m2 / b.pixel_area_m2) * inverse};
}

std::vector<ViewChange> derivatives(const Instrument& instrument, const Pose& pose) {
  std::vector<ViewChange> out;
  for (const std::string& name : instrument.calibration->parameters) {
    for (const GeometryKey& key : geometry_keys()) {
      if (name == key.name) out.push_back(derivative(instrument, pose, key));
    }
  }
  return out;
}

}  // namespace

void ViewChange::add(const ViewChange& other, double factor) {
  origin += factor * other.origin;
  column_step += factor * other.column_step;
  row_step += factor * other.row_step;
  detector_normal += factor * other.detector_normal;
  to_source += factor * other.to_source;
  ln_area += factor * other.ln_area;
}

// Eigenvectors of the correlation matrix, not of the covariance: units must not decide what is small.
std::vector<ViewChange> calibration_changes(const Instrument& instrument, const Pose& pose) {
  if (!instrument.calibration || instrument.calibration->parameters.empty() || instrument.lens_cameramodel) return {};
  const Eigen::MatrixXd& covariance = instrument.calibration->covariance;
  const std::vector<ViewChange> per_unit = derivatives(instrument, pose);
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse = (sigma.array() > 0).select(sigma.array().inverse(), 0.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  std::vector<ViewChange> out;
  for (Eigen::Index j = 0; j < solver.eigenvalues().size(); ++j) {
    if (!(solver.eigenvalues()[j] > 0)) continue;
    ViewChange change;
    for (std::size_t k = 0; k < per_unit.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      change.add(per_unit[k], sigma[i] * solver.eigenvectors()(i, j) * std::sqrt(solver.eigenvalues()[j]));
    }
    out.push_back(change);
  }
  return out;
}

}  // namespace scatmap
