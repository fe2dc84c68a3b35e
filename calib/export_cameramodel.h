#pragma once
#include <Eigen/Core>
#include <string>

#include "scatmap/angles/pixel_plane.h"

namespace scatmap::calib {

/// A bare CCD seen from the illuminated spot is a pinhole camera, exactly: its axes are the pixel axes, its focal
/// lengths the distance of the detector plane in pixels, its centre the foot of the perpendicular.
struct PinholeCamera {
  int columns = 0;
  int rows = 0;
  double focal_column_px = 0;
  double focal_row_px = 0;
  double centre_column_px = 0;
  double centre_row_px = 0;
  Eigen::Matrix3d camera_from_sample;  ///< x along columns, y along rows, z towards the detector; origin at the spot
};

/// @throws Error if one of flip_columns and flip_rows, but not both, mirrors the image: no camera model can express
/// that, and the frames must be flipped first
PinholeCamera pinhole_at_spot(const SampleView& view, int columns, int rows);

/// The text of an mrcal .cameramodel file with LENSMODEL_PINHOLE, every number with 17 digits (mrcal's own writer keeps
/// six decimals). The reference frame is the sample's axes with the spot as origin. `comment`: lines, without '#'.
std::string to_cameramodel(const PinholeCamera& camera, const std::string& comment);

}  // namespace scatmap::calib
