#include "scatmap/angles/pixel_plane.h"

#include <cmath>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/units.h"

namespace scatmap {

SampleView sample_view(const LabView<double>& lab) {
  SampleView view;
  view.origin = lab.sample_from_lab * (lab.pixel_origin - lab.spot);
  view.column_step = lab.sample_from_lab * lab.column_step;
  view.row_step = lab.sample_from_lab * lab.row_step;
  view.detector_normal = lab.sample_from_lab * lab.detector_normal;
  view.to_source = lab.sample_from_lab * lab.to_source;
  view.pixel_area_m2 = lab.column_step.norm() * lab.row_step.norm();
  return view;
}

SampleView sample_view(const Instrument& instrument, const Pose& pose) {
  const LabView<double> lab = lab_view<double>(instrument.geometry, instrument, {pose.stage_rad, pose.arm_rad});
  SampleView view = sample_view(lab);
  const double theta_i = incidence_angle(view);
  constexpr double kGrazing = 89.999 * kRadPerDeg;  // beyond it the illuminated spot is longer than any sample
  if (!(theta_i <= kGrazing)) {
    throw Error({"stage angle", "leaves the front of the sample out of the beam",
                 "an angle of incidence of " + number_text(theta_i * kDegPerRad) + " degrees", "below 89.999 degrees"});
  }
  const double plane_distance = std::abs(view.detector_normal.dot(view.origin));
  const double extent = (instrument.columns * view.column_step + instrument.rows * view.row_step).norm();
  if (!(plane_distance > 1e-12 * (view.origin.norm() + extent))) {
    throw Error({"detector", "lies in one plane with the illuminated spot, so no pixel sees it", {}, {}});
  }
  return view;
}

double incidence_angle(const SampleView& view) { return polar_angle<double>(view.to_source); }

std::optional<PixelPosition> pixel_of_direction(const SampleView& view, const Vector3<double>& direction) {
  // origin + column·u + row·v = t·direction, solved by Cramer's rule with the plane's own normal u × v.
  const Vector3<double> across = view.column_step.cross(view.row_step);
  const double facing = across.dot(direction);
  const double t = across.dot(view.origin) / facing;
  constexpr double kParallel = 1e-13;  // below it `facing` is rounding error
  if (!(std::abs(facing) > kParallel * across.norm() * direction.norm() && t > 0)) return std::nullopt;
  const Vector3<double> in_plane = t * direction - view.origin;
  const double area2 = across.squaredNorm();
  return PixelPosition{in_plane.cross(view.row_step).dot(across) / area2,
                       view.column_step.cross(in_plane).dot(across) / area2};
}

}  // namespace scatmap
