#include "calib/spots_moments.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "scatmap/counts/expected_signal.h"

namespace scatmap::calib {
namespace {

constexpr double kWindowReach = 5;  // standard deviations of the window; beyond it the weight is below 4e-6

struct WindowPixel {
  Eigen::Vector2d at;
  double value_e = 0;
  double variance_e2 = 0;                                  // 0 where filled
  Eigen::Vector2d filled_slope = Eigen::Vector2d::Zero();  // of a filled value by the fitted centre
  bool filled = false;
};

GaussianSpot window_of(const GaussianSpot& spot) {
  const double narrow = spot_axes(spot).minor_px;
  const double add = std::max(0.0, kNarrowestWindow_px * kNarrowestWindow_px - narrow * narrow);
  return gaussian_spot(spot.column_px, spot.row_px, 1, spot.covariance_px2() + add * Eigen::Matrix2d::Identity());
}

struct Crop {
  int first_column;
  int first_row;
  int columns;
  int rows;
};

// Room for the window to move by half its reach.
Crop crop_of(const GaussianSpot& window) {
  const double half_columns = 1.5 * kWindowReach * window.column_sd_px;
  const double half_rows = 1.5 * kWindowReach * std::hypot(window.shear_px, window.row_sd_px);
  const int c = static_cast<int>(std::floor(window.column_px - half_columns)),
            r = static_cast<int>(std::floor(window.row_px - half_rows));
  return {c, r, static_cast<int>(std::ceil(window.column_px + half_columns)) - c + 1,
          static_cast<int>(std::ceil(window.row_px + half_rows)) - r + 1};
}

// Light expected at every pixel of the crop, for shot noise: the local mean of the image, never the pixel itself.
Grid<double> expected_light(const SpotImage& image, const Crop& crop) {
  Grid<double> value(crop.rows, crop.columns, 0.0);
  Grid<float> floor(crop.rows, crop.columns, 1.0F), shot(crop.rows, crop.columns, 1.0F);
  Grid<Mask> mask(crop.rows, crop.columns, kNoData);
  for (int r = 0; r < crop.rows; ++r) {
    for (int c = 0; c < crop.columns; ++c) {
      const int row = r + crop.first_row, column = c + crop.first_column;
      if (row < 0 || column < 0 || row >= image.net_e.rows() || column >= image.net_e.columns()) continue;
      value(r, c) = image.net_e(row, column);
      floor(r, c) = static_cast<float>(image.floor_e2(row, column));
      mask(r, c) = image.mask(row, column);
    }
  }
  return expected_signal(value, floor, shot, mask);
}

std::vector<WindowPixel> window_pixels(const SpotImage& image, const SpotFit& fit, std::size_t spot, const Crop& crop) {
  const Grid<double> light = expected_light(image, crop);
  std::vector<PixelGaussian> gaussians(fit.spots.begin(), fit.spots.end());
  std::vector<WindowPixel> out;
  for (int r = 0; r < crop.rows; ++r) {
    for (int c = 0; c < crop.columns; ++c) {
      const int row = r + crop.first_row, column = c + crop.first_column;
      const bool inside = row >= 0 && column >= 0 && row < image.net_e.rows() && column < image.net_e.columns();
      WindowPixel p;
      p.at = {column, row};
      if (!inside || image.mask(row, column) != 0) {
        const PixelExpectation e = gaussians[spot].at(column, row);
        p.value_e = e.value_e;
        p.filled_slope = {e.gradient[kColumn], e.gradient[kRow]};
        p.filled = true;
      } else {
        p.value_e = image.net_e(row, column) - fit.background_e;
        for (std::size_t k = 0; k < gaussians.size(); ++k) {
          if (k != spot) p.value_e -= gaussians[k].at(column, row).value_e;
        }
        p.variance_e2 = image.floor_e2(row, column) + std::max(0.0, light(r, c));
      }
      out.push_back(p);
    }
  }
  return out;
}

struct Moments {
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Matrix2d slope = Eigen::Matrix2d::Zero();         // of `first` by the window's centre
  Eigen::Matrix2d noise = Eigen::Matrix2d::Zero();         // covariance of `first`
  Eigen::Matrix2d filled_slope = Eigen::Matrix2d::Zero();  // of `first` by the fitted centre
  double sum = 0;
  double filled_sum = 0;
};

Moments moments_in(const std::vector<WindowPixel>& pixels, const GaussianSpot& window, const Eigen::Vector2d& centre) {
  const Eigen::Matrix2d inverse = window.covariance_px2().inverse();
  Moments m;
  for (const WindowPixel& p : pixels) {
    const Eigen::Vector2d d = p.at - centre, scaled = inverse * d;
    const double distance2 = d.dot(scaled);
    if (distance2 > kWindowReach * kWindowReach) continue;
    const double weight = std::exp(-0.5 * distance2);
    m.first += weight * p.value_e * d;
    m.slope += weight * p.value_e * (d * scaled.transpose() - Eigen::Matrix2d::Identity());
    m.noise += weight * weight * p.variance_e2 * d * d.transpose();
    m.filled_slope += weight * d * p.filled_slope.transpose();
    m.sum += weight * p.value_e;
    if (p.filled) m.filled_sum += weight * p.value_e;
  }
  return m;
}

// How far the windowed centroid of the fitted Gaussian, placed at `centre` and seen by the same pixels, lies beside it:
// the error of sampling.
Eigen::Vector2d sampling_error(const SpotFit& fit, std::size_t spot, std::vector<WindowPixel> pixels,
                               const GaussianSpot& window, const Eigen::Vector2d& centre) {
  GaussianSpot model = fit.spots[spot];
  model.column_px = centre.x();
  model.row_px = centre.y();
  const PixelGaussian gaussian(model);
  for (WindowPixel& p : pixels) p.value_e = gaussian.at(static_cast<int>(p.at.x()), static_cast<int>(p.at.y())).value_e;
  const Moments m = moments_in(pixels, window, centre);
  return -m.slope.inverse() * m.first;
}

// By how much the first moment changes with every parameter of the fit: the spot's own centre through the pixels that
// are filled, those of other spots through the light that is taken off.
Eigen::MatrixXd slope_by_fit(const SpotFit& fit, std::size_t spot, const std::vector<WindowPixel>& pixels,
                             const GaussianSpot& window, const Eigen::Vector2d& centre, const Moments& moments) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(2, fit.covariance.cols());
  const auto first_of = [](std::size_t k) { return static_cast<Eigen::Index>(k) * kSpotParameters; };
  out.middleCols<2>(first_of(spot)) = moments.filled_slope;
  const Eigen::Matrix2d inverse = window.covariance_px2().inverse();
  for (std::size_t k = 0; k < fit.spots.size(); ++k) {
    if (k == spot) continue;
    const PixelGaussian other(fit.spots[k]);
    for (const WindowPixel& p : pixels) {
      const Eigen::Vector2d d = p.at - centre;
      const double distance2 = d.dot(inverse * d);
      if (p.filled || distance2 > kWindowReach * kWindowReach) continue;
      const PixelExpectation e = other.at(static_cast<int>(p.at.x()), static_cast<int>(p.at.y()));
      const Eigen::Map<const Eigen::Matrix<double, 1, kSpotParameters>> gradient(e.gradient.data());
      out.middleCols<kSpotParameters>(first_of(k)) -= std::exp(-0.5 * distance2) * d * gradient;
    }
  }
  return out;
}

// The fit and what is taken from it, filled pixels and other spots' light, go wrong together, so their standard
// deviations add, not their variances; and what comes from the fit is no better known than the fit.
Eigen::Matrix2d with_fit(const Eigen::Matrix2d& measured, const Eigen::Matrix2d& filled,
                         const Eigen::Matrix2d& fitted) {
  const double share = filled.trace() / measured.trace();
  if (!(share > 0)) return measured;
  const double together = (1 + std::sqrt(share)) * (1 + std::sqrt(share)) / (1 + share);
  const Eigen::Matrix2d out = together * (measured + filled);
  return out.trace() > fitted.trace() ? out : fitted;
}

}  // namespace

CentroidMoments windowed_centroid(const SpotImage& image, const SpotFit& fit, std::size_t spot) {
  constexpr int kMaxIterations = 60;
  const GaussianSpot window = window_of(fit.spots[spot]);
  const std::vector<WindowPixel> pixels = window_pixels(image, fit, spot, crop_of(window));
  const Eigen::Vector2d start(window.column_px, window.row_px);
  const double smallest = 1e-9 * spot_axes(window).minor_px, farthest = 0.5 * kWindowReach * spot_axes(window).minor_px;
  Eigen::Vector2d centre = start;
  CentroidMoments out;
  for (int i = 0; i < kMaxIterations && !out.converged; ++i) {
    const Moments m = moments_in(pixels, window, centre);
    const Eigen::Vector2d step = -m.slope.inverse() * m.first;
    if (!step.allFinite() || (centre + step - start).norm() > farthest) break;
    centre += step;
    out.converged = step.norm() < smallest;
  }
  const Moments m = moments_in(pixels, window, centre);
  const Eigen::Matrix2d inverse = m.slope.inverse();
  const Eigen::MatrixXd by_fit = inverse * slope_by_fit(fit, spot, pixels, window, centre, m);
  centre -= sampling_error(fit, spot, pixels, window, centre);
  out.column_px = centre.x();
  out.row_px = centre.y();
  out.covariance_px2 = with_fit(inverse * m.noise * inverse.transpose(), by_fit * fit.covariance * by_fit.transpose(),
                                fit.centre_covariance(spot)) +
                       fit.ambiguity_of(spot);
  out.filled_share = m.filled_sum / m.sum;
  return out;
}

}  // namespace scatmap::calib
