#include "calib/directions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "scatmap/angles/pixel_plane.h"
#include "scatmap/base/error.h"
#include "scatmap/base/units.h"

namespace scatmap::calib {
namespace {

std::size_t busiest_mount(const TargetModel& model, const Used& used) {
  std::vector<std::size_t> count(std::max<std::size_t>(model.table().mounts(), 1), 0);
  for (const std::size_t i : used) {
    const Target& t = model.list().targets[i];
    if (t.kind == TargetKind::kSpecular) ++count[t.mount];
  }
  return static_cast<std::size_t>(std::max_element(count.begin(), count.end()) - count.begin());
}

std::vector<Pose> reference_poses(const TargetModel& model, const Used& used) {
  std::vector<Pose> poses;
  for (const std::size_t i : used) {
    const Target& t = model.list().targets[i];
    // At its own specular angle, wherever the arm happened to stand.
    if (t.kind == TargetKind::kSpecular) poses.push_back({t.stage_rad, 2 * t.stage_rad});
  }
  if (poses.empty()) return {{30 * kRadPerDeg, 60 * kRadPerDeg}};
  std::sort(poses.begin(), poses.end(), [](const Pose& a, const Pose& b) { return a.stage_rad < b.stage_rad; });
  std::vector<Pose> out{poses.front(), poses[poses.size() / 2], poses.back()};
  out.erase(
      std::unique(out.begin(), out.end(), [](const Pose& a, const Pose& b) { return a.stage_rad == b.stage_rad; }),
      out.end());
  return out;
}

std::vector<DirectionPoint> points_of(const Instrument& array, const std::vector<Pose>& poses) {
  const double c = array.columns - 1, r = array.rows - 1;
  std::vector<DirectionPoint> points;
  for (const Pose& pose : poses) {
    points.push_back({"centre", c / 2, r / 2, pose});
    points.push_back({"first column, first row", 0, 0, pose});
    points.push_back({"last column, first row", c, 0, pose});
    points.push_back({"first column, last row", 0, r, pose});
    points.push_back({"last column, last row", c, r, pose});
  }
  return points;
}

SampleView view_at(const TargetModel& model, const Eigen::VectorXd& values, std::size_t mount, const Pose& pose) {
  Instrument instrument = model.table().array();
  instrument.geometry = model.table().geometry(values, mount);
  return sample_view(instrument, pose);
}

Eigen::Vector2d pixel_angles(const SampleView& view, const DirectionPoint& p) {
  const Vector3<double> ray = view.pixel(p.column_px, p.row_px);
  const auto angle = [&](const Vector3<double>& step) { return ray.cross(step).norm() / ray.squaredNorm(); };
  return {angle(view.column_step), angle(view.row_step)};
}

Eigen::Vector2d seen_at(const SampleView& view, const Vector3<double>& direction) {
  const auto pixel = pixel_of_direction(view, direction);
  if (!pixel) throw Error({"calibration", "ends with a detector that does not see the sample", {}, {}});
  return {pixel->column, pixel->row};
}

}  // namespace

DirectionEffects direction_effects(const TargetModel& model, const Used& used, const Eigen::VectorXd& values) {
  DirectionEffects out;
  out.mount = busiest_mount(model, used);
  const std::vector<Pose> poses = reference_poses(model, used);
  out.points = points_of(model.table().array(), poses);
  const auto per_pose = static_cast<Eigen::Index>(out.points.size() / poses.size());
  out.px_per_parameter = Eigen::MatrixXd::Zero(2 * static_cast<Eigen::Index>(out.points.size()), model.table().size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const Eigen::Index first = static_cast<Eigen::Index>(k) * per_pose;
    const SampleView view = view_at(model, values, out.mount, poses[k]);
    for (Eigen::Index p = first; p < first + per_pose; ++p)
      out.rad_per_px.push_back(pixel_angles(view, out.points[static_cast<std::size_t>(p)]));
    for (Eigen::Index key = 0; key < static_cast<Eigen::Index>(kGeometryKeyCount); ++key) {
      const Eigen::Index i = ParameterTable::index_of_key(key, out.mount);
      if (i >= model.table().size()) continue;
      // Central difference over a thousandth of the tolerance: truncation and rounding stay below 1e-6 relative.
      constexpr double kStep = 1e-3;
      Eigen::VectorXd plus = values, minus = values;
      plus[i] += kStep * model.table()[i].prior_sigma;
      minus[i] -= kStep * model.table()[i].prior_sigma;
      const SampleView a = view_at(model, plus, out.mount, poses[k]), b = view_at(model, minus, out.mount, poses[k]);
      for (Eigen::Index p = first; p < first + per_pose; ++p) {
        const DirectionPoint& point = out.points[static_cast<std::size_t>(p)];
        const Vector3<double> direction = view.pixel(point.column_px, point.row_px);
        out.px_per_parameter.block<2, 1>(2 * p, i) = (seen_at(a, direction) - seen_at(b, direction)) / (2 * kStep);
      }
    }
  }
  return out;
}

Eigen::MatrixXd effects_of(const DirectionEffects& effects, const ParameterTable& table, const FitSet& set) {
  Eigen::MatrixXd out(effects.px_per_parameter.rows(), static_cast<Eigen::Index>(set.size()));
  for (std::size_t k = 0; k < set.size(); ++k) {
    out.col(static_cast<Eigen::Index>(k)) =
        effects.px_per_parameter.col(set[k].index) * (set[k].scale / table[set[k].index].prior_sigma);
  }
  return out;
}

std::vector<DirectionSigma> direction_sigmas(const DirectionEffects& effects, const ParameterTable& table,
                                             const FitSet& set, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd f = effects_of(effects, table, set);
  std::vector<DirectionSigma> out;
  for (std::size_t k = 0; k < effects.points.size(); ++k) {
    const Eigen::MatrixXd rows = f.middleRows(2 * static_cast<Eigen::Index>(k), 2);
    const Eigen::Matrix2d c = rows * covariance * rows.transpose();
    out.push_back(direction_sigma(effects, k, c));
  }
  return out;
}

DirectionSigma direction_sigma(const DirectionEffects& effects, std::size_t point,
                               const Eigen::Matrix2d& covariance_px2) {
  const Eigen::Vector2d sigma = covariance_px2.diagonal().cwiseMax(0).cwiseSqrt();
  return {effects.points[point], sigma[0], sigma[1], sigma.cwiseProduct(effects.rad_per_px[point]).norm(),
          covariance_px2};
}

Eigen::VectorXd direction_shifts(const TargetModel& model, const DirectionEffects& effects, const Eigen::VectorXd& from,
                                 const Eigen::VectorXd& to) {
  Eigen::VectorXd out(2 * static_cast<Eigen::Index>(effects.points.size()));
  std::optional<SampleView> before, after;
  for (std::size_t k = 0; k < effects.points.size(); ++k) {
    const DirectionPoint& p = effects.points[k];
    if (k == 0 || p.pose.stage_rad != effects.points[k - 1].pose.stage_rad) {
      before = view_at(model, from, effects.mount, p.pose);
      after = view_at(model, to, effects.mount, p.pose);
    }
    const auto seen = pixel_of_direction(*after, before->pixel(p.column_px, p.row_px));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    out.segment<2>(2 * static_cast<Eigen::Index>(k)) =
        seen ? Eigen::Vector2d(seen->column - p.column_px, seen->row - p.row_px) : Eigen::Vector2d(nan, nan);
  }
  return out;
}

}  // namespace scatmap::calib
