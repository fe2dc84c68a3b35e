#pragma once
#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "calib/consensus.h"
#include "calib/selection.h"

namespace scatmap::calib {

/// A finished fit, before it is put into words and numbers for people.
struct FinishedFit {
  const TargetModel& model;
  const Consensus& fit;
  const FitSet& all;                         ///< every candidate
  const std::vector<bool>& kept;             ///< which of them were fitted
  const std::vector<LeftOutCost>& left_out;  ///< of each candidate; empty if none was left out
  int iterations = 0;
};

/// Covariance, per-target residuals, chi² by parts, leave-one-out, observability.
/// @throws Error if the fit is singular: then there is no number to report
CalibrationResult make_result(const FinishedFit& finished, std::vector<std::string> findings);

}  // namespace scatmap::calib
