#pragma once
#include <optional>

#include "scatmap/angles/instrument.h"
#include "scatmap/base/direction.h"
#include "scatmap/base/rotation.h"

namespace scatmap {

/// Beam, sample and detector of one pose in the laboratory frame (docs/conventions.md).
template <class T>
struct LabView {
  Vector3<T> spot;             ///< P: where the beam line meets the sample surface, m
  Vector3<T> to_source;        ///< b, unit
  Matrix3<T> sample_from_lab;  ///< rows: sample x, y, z = normal
  Vector3<T> pixel_origin;     ///< centre of pixel (0, 0), m
  Vector3<T> column_step;      ///< from a pixel to its neighbour in the next column, m
  Vector3<T> row_step;
  Vector3<T> detector_normal;  ///< unit, away from the sample side
};

template <class T>
struct MotorAngles {
  T stage{};
  T arm{};
};

/// Traces the instrument at a pose: design equations of docs/conventions.md.
template <class T>
LabView<T> lab_view(const Geometry<T>& g, const Instrument& array, const MotorAngles<T>& motors) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  LabView<T> view;
  const T stage = motors.stage + g.stage_zero;
  const Matrix3<T> stage_rotation = rotation_y<T>(stage);
  const Vector3<T> normal = stage_rotation * rotation_x<T>(g.sample_tilt).col(2);
  view.to_source = Vector3<T>(T(0), sin(g.beam_elevation), cos(g.beam_elevation));

  // Beam line: A + s k, k = −b. It meets n·X = h at s = (h − n·A)/(n·k).
  const Vector3<T> along = -view.to_source;
  const Vector3<T> through(g.beam_offset_x, g.beam_offset_y, T(0));
  view.spot = through + along * ((g.sample_height - normal.dot(through)) / normal.dot(along));

  // x: in-plane forward. At normal incidence it is undefined and falls back to the stage's x axis.
  Vector3<T> forward = along - normal * along.dot(normal);
  const T length2 = forward.squaredNorm();
  constexpr double kParallel2 = 1e-24;  // |k − (k·n)n| below 1e-12: direction is rounding error
  if (length2 > T(kParallel2)) {
    forward /= sqrt(length2);  // near normal incidence the cancellation above leaves it off the surface
  } else {
    forward = stage_rotation.col(0);
  }
  forward -= normal * forward.dot(normal);
  forward /= sqrt(forward.squaredNorm());
  view.sample_from_lab.row(0) = forward.transpose();
  view.sample_from_lab.row(1) = normal.cross(forward).transpose();
  view.sample_from_lab.row(2) = normal.transpose();

  const Matrix3<T> lab_from_arm =
      rotation_x<T>(g.arm_axis_tilt_x) * rotation_z<T>(g.arm_axis_tilt_z) * rotation_y<T>(motors.arm + g.arm_zero);
  const Matrix3<T> arm_from_detector =
      rotation_z<T>(g.rotation_roll) * rotation_y<T>(g.rotation_yaw) * rotation_x<T>(g.rotation_pitch);
  const Matrix3<T> lab_from_detector = lab_from_arm * arm_from_detector;
  const T column_sign(array.flip_columns ? -1 : 1), row_sign(array.flip_rows ? -1 : 1);
  view.column_step = lab_from_detector.col(0) * (column_sign * g.pixel_column);
  view.row_step = lab_from_detector.col(1) * (row_sign * g.pixel_row);
  view.detector_normal = lab_from_detector.col(2);
  const Vector3<T> centre =
      Vector3<T>(g.arm_axis_x, T(0), g.arm_axis_z) + lab_from_arm * Vector3<T>(g.offset_x, g.offset_y, g.distance);
  view.pixel_origin =
      centre - view.column_step * T(0.5 * (array.columns - 1)) - view.row_step * T(0.5 * (array.rows - 1));
  return view;
}

/// The same in sample axes with the spot as origin: pixel (column, row) lies at origin + column·column_step +
/// row·row_step. Everything per pixel follows from these vectors.
struct SampleView {
  Vector3<double> origin;
  Vector3<double> column_step;
  Vector3<double> row_step;
  Vector3<double> detector_normal;
  Vector3<double> to_source;
  double pixel_area_m2 = 0;

  /// The row's part first: along a row each coordinate then grows or falls without a step back, rounding included,
  /// and every method finds the same columns above the horizon.
  Vector3<double> pixel(double column, double row) const { return (origin + row * row_step) + column * column_step; }
};

/// @throws Error if the beam grazes or misses the sample surface, or the spot lies in the detector plane
SampleView sample_view(const Instrument& instrument, const Pose& pose);
SampleView sample_view(const LabView<double>& lab);

/// Angle of incidence, rad.
double incidence_angle(const SampleView& view);

struct PixelPosition {
  double column;
  double row;
};

/// Where the ray from the spot along `direction` (sample axes, any length) meets the detector plane: the closed-form
/// inverse of SampleView::pixel. nullopt if it never does (parallel, or on the other side). May lie off the array.
std::optional<PixelPosition> pixel_of_direction(const SampleView& view, const Vector3<double>& direction);

}  // namespace scatmap
