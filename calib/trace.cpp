#include "calib/trace.h"

#include <cmath>

#include "scatmap/base/rotation.h"

namespace scatmap::calib {

// The beam as it comes to the detector: points at + t·along. A mirror maps the incident line point by point, so t means
// the same place before and after. `from` is where it leaves mirror or origin.
struct Tracer::Line {
  Vector3<double> at, along;
  double from = 0;
  Vector3<double> normal;       // of the mirror
  Vector3<double> normal_tilt;  // its change with the tilt
};

// Where that line meets the detector plane, lab axes.
struct Tracer::Hit {
  Matrix3<double> lab_from_arm;
  double t = 0;
  Vector3<double> at, from_centre;
};

Tracer::Tracer(const Geometry<double>& g, const Instrument& array)
    : arm_zero_(g.arm_zero),
      stage_zero_(g.stage_zero),
      axis_(rotation_x<double>(g.arm_axis_tilt_x) * rotation_z<double>(g.arm_axis_tilt_z)),
      axis_offset_(g.arm_axis_x, 0, g.arm_axis_z),
      mount_offset_(g.offset_x, g.offset_y, g.distance),
      beam_point_(g.beam_offset_x, g.beam_offset_y, 0),
      along_(0, -std::sin(g.beam_elevation), -std::cos(g.beam_elevation)),
      d_along_(0, -std::cos(g.beam_elevation), std::sin(g.beam_elevation)),
      middle_(0.5 * (array.columns - 1), 0.5 * (array.rows - 1)),
      pitch_(g.pixel_column, g.pixel_row) {
  const Matrix3<double> roll = rotation_z<double>(g.rotation_roll);
  const Matrix3<double> yaw = roll * rotation_y<double>(g.rotation_yaw);
  mount_ = yaw * rotation_x<double>(g.rotation_pitch);
  pitch_axis_ = yaw.col(0);
  yaw_axis_ = roll.col(1);
  tilt_z_axis_ = rotation_x<double>(g.arm_axis_tilt_x).col(2);
  per_pixel_ = {(array.flip_columns ? -1 : 1) / g.pixel_column, (array.flip_rows ? -1 : 1) / g.pixel_row};
}

std::optional<Tracer::Line> Tracer::line_of(const Shot& shot) const {
  Line line;
  line.at = beam_point_;
  line.along = along_;
  if (shot.kind == TargetKind::kDirect) return line;
  const double stage = shot.stage_rad + stage_zero_;
  const double cs = std::cos(stage), ss = std::sin(stage), ct = std::cos(shot.tilt_rad), st = std::sin(shot.tilt_rad);
  line.normal = {ss * ct, -st, cs * ct};
  line.normal_tilt = {-ss * st, -ct, -cs * st};
  const double facing = along_.dot(line.normal);
  if (!(facing < 0)) return std::nullopt;
  const double below = shot.height_m - line.normal.dot(beam_point_);
  line.from = below / facing;
  line.at += 2 * below * line.normal;
  line.along -= 2 * facing * line.normal;
  return line;
}

// By how much the beam moves against the detector at the hit, per metre or radian of each parameter.
Tracer::Displacements Tracer::displacements(const Shot& shot, const Line& line, const Hit& hit) const {
  const Matrix3<double>& arm = hit.lab_from_arm;
  const Vector3<double> from_axis = hit.at - axis_offset_;
  Displacements g = Displacements::Zero();
  g.col(0) = -arm.col(2);
  g.col(1) = -arm.col(0);
  g.col(2) = -arm.col(1);
  g.col(3) = hit.from_centre.cross(arm * pitch_axis_);
  g.col(4) = hit.from_centre.cross(arm * yaw_axis_);
  g.col(5) = hit.from_centre.cross(arm.col(2));
  g.col(kArmZeroColumn) = from_axis.cross(axis_.col(1));
  g.col(9) = -Vector3<double>::UnitX();
  g.col(10) = -Vector3<double>::UnitZ();
  g.col(11) = from_axis.cross(Vector3<double>::UnitX());
  g.col(12) = from_axis.cross(tilt_z_axis_);
  g.col(14) = Vector3<double>::UnitX();
  g.col(15) = Vector3<double>::UnitY();
  g.col(16) = hit.t * d_along_;
  if (shot.kind == TargetKind::kDirect) return g;
  const Vector3<double>& n = line.normal;
  for (Eigen::Index i = 14; i <= 16; ++i) g.col(i) -= 2 * n.dot(g.col(i)) * n;
  const Vector3<double> incident = beam_point_ + hit.t * along_;
  const double above = n.dot(incident) - shot.height_m;
  const auto turned = [&](const Vector3<double>& dn) {
    return Vector3<double>(-2 * (dn.dot(incident) * n + above * dn));
  };
  g.col(kStageZeroColumn) = turned({n.z(), 0, -n.x()});
  g.col(kTiltColumn) = turned(line.normal_tilt);
  g.col(kHeightColumn) = 2 * n;
  return g;
}

std::optional<Trace> Tracer::trace(const Shot& shot) const {
  const std::optional<Line> line = line_of(shot);
  if (!line) return std::nullopt;
  Hit hit;
  hit.lab_from_arm = axis_ * rotation_y<double>(shot.arm_rad + arm_zero_);
  const Matrix3<double> lab_from_detector = hit.lab_from_arm * mount_;
  const Vector3<double> centre = axis_offset_ + hit.lab_from_arm * mount_offset_;
  const Vector3<double> facing = lab_from_detector.col(2);
  const double closing = line->along.dot(facing);
  hit.t = (centre - line->at).dot(facing) / closing;
  if (!(closing > 0 && hit.t > line->from)) return std::nullopt;
  hit.at = line->at + hit.t * line->along;
  hit.from_centre = hit.at - centre;

  Trace out;
  // The hit moves by the displacement less its part along the beam.
  Eigen::Matrix<double, 2, 3> to_pixel;
  for (Eigen::Index i = 0; i < 2; ++i) {
    const Vector3<double> axis = lab_from_detector.col(i);
    out.pixel[i] = middle_[i] + per_pixel_[i] * axis.dot(hit.from_centre);
    to_pixel.row(i) = per_pixel_[i] * (axis - (axis.dot(line->along) / closing) * facing).transpose();
  }
  out.jacobian.noalias() = to_pixel * displacements(shot, *line, hit);
  out.jacobian(0, 6) = -(out.pixel[0] - middle_[0]) / pitch_[0];
  out.jacobian(1, 7) = -(out.pixel[1] - middle_[1]) / pitch_[1];
  return out;
}

}  // namespace scatmap::calib
