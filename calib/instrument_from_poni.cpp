#include "calib/instrument_from_poni.h"

#include <cmath>

#include "scatmap/base/error.h"

namespace scatmap::calib {
namespace {

// The arm as a frame: its axes and the arm axis' place, lab coordinates.
struct ArmFrame {
  Matrix3<double> lab_from_arm;
  Vector3<double> axis_m;
};

// Read off a detector that is mounted straight: then its axes are the arm's.
ArmFrame arm_frame(const Instrument& like, const Pose& pose) {
  Instrument straight = like;
  straight.columns = straight.rows = 1;
  straight.flip_columns = straight.flip_rows = false;
  Geometry<double>& g = straight.geometry;
  g.offset_x = g.offset_y = g.rotation_pitch = g.rotation_yaw = g.rotation_roll = 0;
  const LabView<double> lab = lab_view<double>(g, straight, {pose.stage_rad, pose.arm_rad});
  ArmFrame out;
  out.lab_from_arm << lab.column_step / g.pixel_column, lab.row_step / g.pixel_row, lab.detector_normal;
  out.axis_m = lab.pixel_origin - g.distance * lab.detector_normal;
  return out;
}

void check_size(const Poni& poni, const Instrument& like) {
  if (poni.columns == 0 || (poni.columns == like.columns && poni.rows == like.rows)) return;
  throw Error({"max_shape", "is not the instrument's detector",
               std::to_string(poni.columns) + " x " + std::to_string(poni.rows),
               std::to_string(like.columns) + " x " + std::to_string(like.rows)});
}

}  // namespace

Instrument instrument_from_poni(const Poni& poni, const Instrument& like, const Pose& pose) {
  if (like.lens_cameramodel)
    throw Error({"detector.lens_cameramodel", "has no place in a .poni file: it describes a flat detector", {}, {}});
  check_size(poni, like);
  const PoniAxes axes = like.flip_columns == like.flip_rows ? PoniAxes::kYxz : PoniAxes::kXyz;
  const SampleView view = view_from_poni({poni, axes}, sample_view(like, pose).to_source);
  const LabView<double> lab = lab_view<double>(like.geometry, like, {pose.stage_rad, pose.arm_rad});
  const ArmFrame arm = arm_frame(like, pose);
  const Matrix3<double> arm_from_sample = arm.lab_from_arm.transpose() * lab.sample_from_lab.transpose();
  const Vector3<double> spot = arm.lab_from_arm.transpose() * (lab.spot - arm.axis_m);
  const Vector3<double> centre = spot + arm_from_sample * view.pixel(0.5 * (like.columns - 1), 0.5 * (like.rows - 1));
  if (!(centre.z() > 0))
    throw Error({"detector", "would lie behind the arm's axis: the file belongs to another pose", {}, {}});

  Instrument out = like;
  out.calibration.reset();
  Geometry<double>& g = out.geometry;
  g.pixel_column = poni.column_pitch_m;
  g.pixel_row = poni.row_pitch_m;
  g.offset_x = centre.x();
  g.offset_y = centre.y();
  g.distance = centre.z();
  Matrix3<double> r;  // Rz(roll)·Ry(yaw)·Rx(pitch)
  r << arm_from_sample * view.column_step.normalized() * (like.flip_columns ? -1 : 1),
      arm_from_sample * view.row_step.normalized() * (like.flip_rows ? -1 : 1), arm_from_sample * view.detector_normal;
  g.rotation_pitch = std::atan2(r(2, 1), r(2, 2));
  g.rotation_yaw = std::atan2(-r(2, 0), std::hypot(r(2, 1), r(2, 2)));
  g.rotation_roll = std::atan2(r(1, 0), r(0, 0));
  return out;
}

}  // namespace scatmap::calib
