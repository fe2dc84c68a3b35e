#include "scatmap/brdf/pose_uncertainty.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <string>
#include <vector>

#include "scatmap/base/parallel_rows.h"

namespace scatmap {
namespace {

// Change of a SampleView per unit of something; linear in small changes, so it adds and scales.
struct ViewChange {
  Vector3<double> origin = Vector3<double>::Zero(), column_step = origin, row_step = origin;
  Vector3<double> detector_normal = origin, to_source = origin;
  double ln_area = 0;

  void add(const ViewChange& other, double factor) {
    origin += factor * other.origin;
    column_step += factor * other.column_step;
    row_step += factor * other.row_step;
    detector_normal += factor * other.detector_normal;
    to_source += factor * other.to_source;
    ln_area += factor * other.ln_area;
  }
};

// Central difference over ±1e-3 of a file unit (µm, mdeg): truncation and rounding both stay below 1e-8 relative.
ViewChange derivative(const Instrument& instrument, const Pose& pose, const GeometryKey& key) {
  constexpr double kStep = 1e-3;
  Instrument plus = instrument, minus = instrument;
  plus.geometry.*key.member += kStep * key.unit;
  minus.geometry.*key.member -= kStep * key.unit;
  const SampleView a = sample_view(plus, pose), b = sample_view(minus, pose);
  const double inverse = 1 / (2 * kStep);
  return {(a.origin - b.origin) * inverse, (a.column_step - b.column_step) * inverse, (a.row_step - b.row_step) * inverse,
          (a.detector_normal - b.detector_normal) * inverse, (a.to_source - b.to_source) * inverse,
          std::log(a.pixel_area_m2 / b.pixel_area_m2) * inverse};
}

// One change per eigenvector of the correlation matrix (units must not decide what is small), scaled to one sigma.
std::vector<ViewChange> independent_changes(const Instrument& instrument, const Pose& pose) {
  const Calibration& calibration = *instrument.calibration;
  std::vector<ViewChange> derivatives;
  for (const std::string& name : calibration.parameters) {
    for (const GeometryKey& key : geometry_keys()) {
      if (name == key.name) derivatives.push_back(derivative(instrument, pose, key));
    }
  }
  const Eigen::VectorXd sigma = calibration.covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse = (sigma.array() > 0).select(sigma.array().inverse(), 0.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(inverse.asDiagonal() * calibration.covariance * inverse.asDiagonal());
  std::vector<ViewChange> out;
  for (Eigen::Index j = 0; j < solver.eigenvalues().size(); ++j) {
    if (!(solver.eigenvalues()[j] > 0)) continue;
    ViewChange change;
    for (std::size_t k = 0; k < derivatives.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      change.add(derivatives[k], sigma[i] * solver.eigenvectors()(i, j) * std::sqrt(solver.eigenvalues()[j]));
    }
    out.push_back(change);
  }
  return out;
}

struct Slope {
  double x, y;
};

// Change of the half vector's slopes (ux/uz, uy/uz), u = b + v, when the ray changes by d_ray and b by d_source.
Slope slope_change(const Vector3<double>& ray, double r, const Vector3<double>& u, const Vector3<double>& d_ray, const Vector3<double>& d_source) {
  const Vector3<double> v = ray / r;
  const Vector3<double> du = (d_ray - v * v.dot(d_ray)) / r + d_source;
  return {(du.x() - u.x() / u.z() * du.z()) / u.z(), (du.y() - u.y() / u.z() * du.z()) / u.z()};
}

// Everything about one pixel that does not depend on which parameter changes.
struct PixelState {
  Vector3<double> ray, half_sum;
  double r, r2, facing;
  Slope per_column, per_row;
  double determinant;
};

PixelState pixel_state(const SampleView& view, int row, int column) {
  PixelState p;
  p.ray = view.pixel(column, row);
  p.r2 = p.ray.squaredNorm();
  p.r = std::sqrt(p.r2);
  p.half_sum = view.to_source + p.ray / p.r;
  p.facing = view.detector_normal.dot(p.ray);
  p.per_column = slope_change(p.ray, p.r, p.half_sum, view.column_step, Vector3<double>::Zero());
  p.per_row = slope_change(p.ray, p.r, p.half_sum, view.row_step, Vector3<double>::Zero());
  p.determinant = p.per_column.x * p.per_row.y - p.per_column.y * p.per_row.x;
  return p;
}

struct Gradient {
  double f, per_column, per_row;
};

double sensitivity(const SampleView& view, const PixelState& p, const ViewChange& change, int row, int column, const Gradient& g) {
  const Vector3<double> d_ray = change.origin + column * change.column_step + row * change.row_step;
  const double along = p.ray.dot(d_ray) / p.r2;
  const double d_ln_omega =
      change.ln_area + (change.detector_normal.dot(p.ray) + view.detector_normal.dot(d_ray)) / p.facing - 3 * along;
  const double d_ln_cos = d_ray.z() / p.ray.z() - along;
  const Slope s = slope_change(p.ray, p.r, p.half_sum, d_ray, change.to_source);
  const double d_column = (s.x * p.per_row.y - s.y * p.per_row.x) / p.determinant;
  const double d_row = (p.per_column.x * s.y - p.per_column.y * s.x) / p.determinant;
  return g.f * (d_ln_omega + d_ln_cos) + g.per_column * d_column + g.per_row * d_row;
}

double difference(double before, double here, double after) {
  if (std::isfinite(before) && std::isfinite(after)) return 0.5 * (after - before);
  if (std::isfinite(after)) return after - here;
  if (std::isfinite(before)) return here - before;
  return 0;
}

Gradient gradient(const Grid<double>& f, int row, int column) {
  const auto at = [&](int r, int c) {
    return r < 0 || c < 0 || r >= f.rows() || c >= f.columns() ? std::nan("") : f(r, c);
  };
  const double here = f(row, column);
  return {here, difference(at(row, column - 1), here, at(row, column + 1)), difference(at(row - 1, column), here, at(row + 1, column))};
}

}  // namespace

std::optional<Grid<float>> pose_uncertainty(const Instrument& instrument, const Pose& pose, const Grid<double>& expected_per_sr) {
  if (!instrument.calibration || instrument.calibration->parameters.empty()) return std::nullopt;
  const SampleView view = sample_view(instrument, pose);
  const std::vector<ViewChange> changes = independent_changes(instrument, pose);
  Grid<float> out(expected_per_sr.rows(), expected_per_sr.columns());
  for_each_row(out.rows(), [&](int row) {
    for (int c = 0; c < out.columns(); ++c) {
      const Gradient g = gradient(expected_per_sr, row, c);
      const PixelState p = pixel_state(view, row, c);
      double sum = 0;
      for (const ViewChange& change : changes) {
        const double s = sensitivity(view, p, change, row, c, g);
        sum += s * s;
      }
      out(row, c) = static_cast<float>(std::sqrt(sum));
    }
  });
  return out;
}

}  // namespace scatmap
