#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "calib/parameters.h"
#include "calib/target_model.h"

namespace scatmap::calib {

/// Where a fit begins, and what is plainly wrong with the nominal file.
struct Start {
  ParameterTable table;               ///< with the flips that the spots show, and roll and offsets taken from them
  Eigen::VectorXd values;             ///< m and rad
  Used near;                          ///< targets that agree with it
  std::vector<std::string> findings;  ///< "the columns run the other way …"
};

/// Where to begin, most promising first: the closed form, the same with the other handedness, and the nominal file as
/// it is.
///
/// Closed form: seen along the arm's boresight the predicted beam slopes s (complex, x + iy) and the spots z on the
/// detector (x + iy, metres) are similar figures up to small terms: z = α s + c, or α conj(s) + c for a mirrored array.
/// Two spots give α: distance |α|, so it is positive always, and roll arg α. RANSAC over pairs of the largest group (a
/// mount, or the direct beam); every other group gets its own shift c, from which follow stage zero and mount tilts.
/// What spots cannot say (one spot, no spread, spots on a line: mirrored or not) stays nominal. Deterministic.
/// @throws Error if no target's beam reaches the detector with the nominal instrument
std::vector<Start> starts(const ParameterTable& nominal, const TargetList& list);

}  // namespace scatmap::calib
