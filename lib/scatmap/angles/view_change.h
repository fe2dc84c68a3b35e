#pragma once
#include <vector>

#include "scatmap/angles/pixel_plane.h"

namespace scatmap {

/// Change of a SampleView at one standard deviation of something; linear in small changes, so it adds and scales.
struct ViewChange {
  Vector3<double> origin = Vector3<double>::Zero();
  Vector3<double> column_step = Vector3<double>::Zero();
  Vector3<double> row_step = Vector3<double>::Zero();
  Vector3<double> detector_normal = Vector3<double>::Zero();
  Vector3<double> to_source = Vector3<double>::Zero();
  double ln_area = 0;  ///< of a pixel

  void add(const ViewChange& other, double factor);
  /// Of the vector from the spot to a pixel.
  Vector3<double> of_pixel(double column, double row) const { return origin + column * column_step + row * row_step; }
};

/// The calibration covariance as independent causes: one change per eigenvector, each at one standard deviation. The
/// covariance of anything first order in the geometry is the sum of their squares and products. Empty without a
/// calibration, and with a lens, whose rays are not of this form. Derivatives are central differences, good to 1e-8
/// relative. @throws Error if the pose is impossible
std::vector<ViewChange> calibration_changes(const Instrument& instrument, const Pose& pose);

}  // namespace scatmap
