#pragma once
#include <optional>

#include "scatmap/angles/view_change.h"
#include "scatmap/base/grid.h"
#include "scatmap/base/mask.h"

namespace scatmap {

/// Standard uncertainty of each pixel's scatter angles from the calibration covariance, first order.
struct AngleUncertainty {
  Grid<float> theta_s_rad;
  /// At the pole phi is undefined: its uncertainty grows as 1/sin(theta_s), up to that of an angle nothing is known of,
  /// pi/√3.
  Grid<float> phi_s_rad;
  Grid<float> correlation;  ///< of theta_s and phi_s, −1 to 1
  Grid<float>
      direction_px;  ///< of the pixel that sees a given direction: root of the summed variances along columns and rows
};

/// @return rows × columns, NaN where `mask` is not 0; nullopt if the instrument has no calibrated parameter, or has a
/// lens
std::optional<AngleUncertainty> angle_uncertainty(const Instrument& instrument, const Pose& pose,
                                                  const Grid<Mask>& mask);

/// The smallest direction_px among nine pixels of the frame: corners, middles of the edges, centre. nullopt if the
/// instrument has no calibrated parameter
std::optional<double> smallest_direction_sigma_px(const Instrument& instrument, const Pose& pose);

}  // namespace scatmap
