#pragma once
#include <cstdint>
#include <vector>

#include "calib/calibrate.h"

namespace scatmap::calib {

enum class BootstrapKind {
  kParametric,  ///< new noise by the stated sigma_px and encoder sigmas: checks the linearisation
  kResiduals,  ///< the fit's own residuals, brought to their full variance and dealt out anew: checks stated sigmas too
  kCases,  ///< settings drawn with replacement: assumes nothing of the noise; needs many more settings than parameters
};

struct BootstrapOptions {
  BootstrapKind kind = BootstrapKind::kParametric;
  int trials = 1000;
  std::uint64_t seed = 1;
};

/// Scatter of many solutions about the calibration's own.
struct Bootstrap {
  std::vector<DirectionSigma> directions;  ///< as CalibrationResult::directions, from the scatter
  std::vector<double> parameter_sigma;     ///< of result.set, file units
  int trials = 0;
  int failed = 0;  ///< trials without convergence, which took no part
};

/// Fits everything that is not held anew, `trials` times, from the solution: Gauss-Newton with halved steps, weights
/// frozen, until the next step gains less than kBootstrapDecrement of chi². The priors are measurements like the
/// targets, so each trial draws them anew as well. Trial k depends on seed and k alone, whatever the number of threads.
/// Directions are followed without linearisation.
/// @param result from calibrate() with the same list
/// @throws Error if trials is not 2 to 10 million, or more than half of them fail
Bootstrap bootstrap(const TargetList& list, const CalibrationResult& result, const BootstrapOptions& options);

inline constexpr double kBootstrapDecrement = 1e-6;

}  // namespace scatmap::calib
