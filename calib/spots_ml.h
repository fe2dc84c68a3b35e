#pragma once
#include <Eigen/Core>
#include <vector>

#include "calib/spots_gaussian.h"
#include "calib/spots_image.h"

namespace scatmap::calib {

/// Gaussian spots on a constant background, fitted together.
struct SpotFit {
  std::vector<GaussianSpot> spots;
  double background_e = 0;
  Eigen::MatrixXd covariance;  ///< inverse Fisher information of (kSpotParameters per spot in order, background)
  double chi2 = 0;             ///< of the fit to the noise alone
  int degrees_of_freedom = 0;
  bool misfit = false;  ///< chi2 is too large for noise: the model's own error was estimated and entered the covariance
  bool converged = false;
  /// Per spot, px²: what light of a neighbour that cannot be told apart leaves open of the centre. Empty: nothing.
  std::vector<Eigen::Matrix2d> ambiguity_px2;

  /// Covariance of a spot's (column, row), px²; with ambiguity.
  Eigen::Matrix2d centre_covariance(std::size_t spot) const;
  Eigen::Matrix2d ambiguity_of(std::size_t spot) const;
};

/// Maximum likelihood for Poisson light and normal noise of variance floor: counts + floor is taken as Poisson about
/// E + floor, which has the right mean and variance at every pixel, so that the score is unbiased and the information
/// is that of Poisson and read noise together (F. Huang et al., Nature Methods 10, 653 (2013)). Fisher scoring with
/// Levenberg's damping. Pixels within kFitReach standard deviations of any spot take part, masked ones do not; isolated
/// residuals, bright or dark, are taken for hot or dead pixels, left out and marked kHot in the image. Where chi2 shows
/// that the light is no Gaussian, one variance common to all pixels is added that brings chi2 to its degrees of
/// freedom, and the fit is repeated. Not converged, or fewer pixels than parameters: `converged` is false and the
/// numbers mean nothing.
SpotFit fit_spots(SpotImage& image, std::vector<GaussianSpot> start);

/// Standard deviations of the spot, widened by 1.5 px, up to which pixels are fitted: what lies beyond holds 0.3 % of
/// the information on the centre.
inline constexpr double kFitReach = 4;

}  // namespace scatmap::calib
