#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calib/directions.h"
#include "calib/observability.h"
#include "calib/parameters.h"
#include "calib/solve.h"
#include "calib/targets.h"

namespace scatmap::calib {

struct CalibrateOptions {
  ParameterChoices choices;
  double reject_sigma = 5;    ///< targets further from the fit than this many standard deviations are left out
  double tolerance_px = 0.1;  ///< a parameter the targets are blind to is carried if it may move directions by more
  bool select = true;         ///< false: every parameter that is not held is fitted
};

enum class Outcome {
  kFitted,   ///< the targets decide
  kCarried,  ///< in the fit, but its value and uncertainty come mostly from the mechanical prior
  kLeftOut,  ///< at its nominal value: the targets do not need it
  kHeld,     ///< at its nominal value: not asked for
};

struct ParameterResult {
  std::string name;
  double nominal = 0;  ///< file units, as the following
  double value = 0;
  double sigma = 0;                   ///< standard uncertainty; 0 if held
  std::optional<double> prior_sigma;  ///< the prior that took part
  Outcome outcome = Outcome::kFitted;
  double bound_px = 0;  ///< kLeftOut: by how much directions may be wrong for it
};

struct TargetResult {
  Eigen::Vector2d residual_px =
      Eigen::Vector2d::Zero();                         ///< predicted less observed; NaN if the beam misses the detector
  Eigen::Vector2d sigma_px = Eigen::Vector2d::Zero();  ///< of the residual, encoder errors included
  double distance = 0;                                 ///< of the residual from 0, standard deviations
  bool used = false;
  std::optional<Eigen::Vector2d> left_out_px;  ///< residual against a fit without this target's setting
};

/// A share of χ², and the degrees of freedom that go with it.
struct ChiSquare {
  std::string part;
  double value = 0;
  double degrees = 0;
};

struct CalibrationResult {
  Instrument instrument;  ///< calibrated, with covariance and what was left out
  std::vector<DirectionSigma> directions;
  std::vector<ParameterResult> parameters;  ///< of the whole table
  FitSet set;                               ///< what has an uncertainty: all but what is held
  Eigen::VectorXd values;                   ///< of the whole table, m and rad
  Eigen::MatrixXd covariance;               ///< of the set, m and rad
  std::vector<TargetResult> targets;
  std::vector<ChiSquare> chi2;  ///< total first
  double left_out_rms = 0;      ///< leave-one-out residuals, standard deviations; 1 when all is well
  double condition = 1;
  Observability observability;
  std::vector<std::string> findings;  ///< what the user must know, in sentences
  int iterations = 0;
  bool converged = false;
};

/// From targets and a nominal instrument to a calibrated one.
/// @throws Error: a detector behind a lens, targets that reach no detector, that do not agree with each other, or that
/// do not determine what
///         `options` leaves free without a prior
CalibrationResult calibrate(const TargetList& list, const Instrument& nominal, const CalibrateOptions& options = {});

}  // namespace scatmap::calib
