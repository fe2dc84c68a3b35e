#pragma once
#include <limits>
#include <string>
#include <vector>

#include "scatmap/report/gnuplot.h"

namespace scatmap::tools {

enum class Verdict {
  kHolds,           ///< within its bound
  kIllConditioned,  ///< beyond it, by no more than rounding the inputs does to the true answer
  kFallsBack,       ///< the method hands over to one that holds, and says so
  kRefuses,         ///< no number, and a reason
  kFails,           ///< a wrong number, or none where there should be one
};
const char* to_string(Verdict verdict);

/// One method in one regime.
struct StabilityCell {
  std::string job;
  std::string regime;
  std::string method;
  std::string unit;  ///< of the errors; "" for relative
  double worst_error = std::numeric_limits<double>::quiet_NaN();
  double bound = std::numeric_limits<double>::quiet_NaN();
  /// Largest change of the answer over the largest change of the truth, when every input moves by one unit in its last
  /// place, up or down; NaN where the inputs are not numbers.
  double amplification_ulp = std::numeric_limits<double>::quiet_NaN();
  /// The same for a step of one standard uncertainty of a plain bench: 1 where the method follows its inputs.
  double amplification_sigma = std::numeric_limits<double>::quiet_NaN();
  Verdict verdict = Verdict::kFails;
  std::string reason;  ///< of a refusal, a fallback, a failure, or of amplifications that are not there
};

std::vector<StabilityCell> stability_angles();
std::vector<StabilityCell> stability_inverse();
std::vector<StabilityCell> stability_lens();
std::vector<StabilityCell> stability_model();
std::vector<StabilityCell> stability_brdf();
std::vector<StabilityCell> stability_calibrate();
std::vector<StabilityCell> stability_uncertainty();
std::vector<StabilityCell> stability_spots();

/// Every method in every regime. Takes about 20 s.
std::vector<StabilityCell> stability_matrix();

/// The matrix is good unless a cell FAILS. @throws Error that counts them and names the first
void require_no_failure(const std::vector<StabilityCell>& cells);

/// Table for people, one line per cell.
std::string stability_text(const std::vector<StabilityCell>& cells);
std::string stability_csv(const std::vector<StabilityCell>& cells);
/// One picture per job: regimes down, methods across, verdict as colour, worst error over bound as number.
Plot stability_plot(const std::vector<StabilityCell>& cells, const std::string& job);

}  // namespace scatmap::tools
