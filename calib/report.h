#pragma once
#include <string>

#include "calib/calibrate.h"

namespace scatmap::calib {

/// For people: where pixels look and how well that is known, first; then findings, parameters, targets.
std::string report_text(const TargetList& list, const CalibrationResult& result);

/// The same and more as JSON: per-target residuals, correlations, singular values. Angles of directions in mrad and
/// deg.
std::string report_json(const TargetList& list, const CalibrationResult& result);

/// "fitted", "carried", "left out", "held".
const char* to_string(Outcome outcome);

}  // namespace scatmap::calib
