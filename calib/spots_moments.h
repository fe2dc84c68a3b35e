#pragma once
#include <Eigen/Core>

#include "calib/spots_ml.h"

namespace scatmap::calib {

struct CentroidMoments {
  double column_px = 0;
  double row_px = 0;
  Eigen::Matrix2d covariance_px2;
  double filled_share = 0;  ///< of the weight that fell on pixels without measurement
  bool converged = false;
};

/// The point about which the first moments of the image vanish under a Gaussian window of the spot's own shape, at
/// least kNarrowestWindow_px wide, iterated until the window sits on it (E. Bertin, SExtractor, "windowed positions").
/// Its covariance comes from the noise model alone: that of the moments, with the local mean of the image for the shot
/// noise, through the derivative of the moments by the window's place. The shift that the same pixels give a Gaussian
/// of the fitted shape is taken off (1e-3 px at a width of 0.7 px, nothing above 1 px). Background and other spots of
/// the fit are taken off; masked pixels and those beyond the frame are filled from the fit, whose own uncertainty is
/// then added.
CentroidMoments windowed_centroid(const SpotImage& image, const SpotFit& fit, std::size_t spot);

/// A narrower window would see the pixels instead of the spot.
inline constexpr double kNarrowestWindow_px = 1.3;

}  // namespace scatmap::calib
