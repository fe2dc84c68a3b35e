#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "calib/target_model.h"

namespace scatmap::calib {

/// A pixel at a pose of the motors: what users act on is where it looks, which no choice of gauge changes.
struct DirectionPoint {
  std::string where;  ///< "centre", "first column, last row", …
  double column_px = 0;
  double row_px = 0;
  Pose pose;
};

/// How directions move with the parameters, in pixels: by how much the pixel that sees a fixed direction (sample axes)
/// moves per scaled parameter. Rows 2k and 2k + 1 are the column and the row of points[k].
struct DirectionEffects {
  std::size_t mount = 0;  ///< whose tilt and height stand for the sample's
  std::vector<DirectionPoint> points;
  Eigen::MatrixXd px_per_parameter;         ///< 2·points × ParameterTable, per Parameter::prior_sigma
  std::vector<Eigen::Vector2d> rad_per_px;  ///< angle of one pixel along columns and along rows, at each point
};

/// Centre and corners of the array, at the specular settings with the smallest, the median and the largest stage angle
/// among `used`; stage 30, arm 60 degrees where there is none. The mount is the one with most targets.
/// @throws Error if the detector does not see the sample there
DirectionEffects direction_effects(const TargetModel& model, const Used& used, const Eigen::VectorXd& values);

/// Standard uncertainty of the direction of one pixel.
struct DirectionSigma {
  DirectionPoint point;
  double column_px = 0;
  double row_px = 0;
  double rad = 0;                                            ///< root of the summed variances along columns and rows
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();  ///< of (column, row)
};

/// @param covariance of the scaled parameters of `set`
std::vector<DirectionSigma> direction_sigmas(const DirectionEffects& effects, const ParameterTable& table,
                                             const FitSet& set, const Eigen::MatrixXd& covariance);

/// The same from a covariance of (column, row) of points[point].
DirectionSigma direction_sigma(const DirectionEffects& effects, std::size_t point,
                               const Eigen::Matrix2d& covariance_px2);

/// By how many pixels the pixels that see the directions of `effects.points` move from one set of values to another,
/// without linearisation: column and row of each point in turn. NaN where the detector does not see one.
Eigen::VectorXd direction_shifts(const TargetModel& model, const DirectionEffects& effects, const Eigen::VectorXd& from,
                                 const Eigen::VectorXd& to);

/// Columns of `effects` for a fit's parameters, per its own scales.
Eigen::MatrixXd effects_of(const DirectionEffects& effects, const ParameterTable& table, const FitSet& set);

}  // namespace scatmap::calib
