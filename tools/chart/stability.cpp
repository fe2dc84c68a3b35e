#include "tools/chart/stability.h"

namespace scatmap::tools {

std::vector<StabilityCell> stability_matrix() {
  std::vector<StabilityCell> out;
  for (const auto& suite : {stability_angles, stability_inverse, stability_lens, stability_model, stability_brdf,
                            stability_uncertainty, stability_spots, stability_calibrate}) {
    const std::vector<StabilityCell> cells = suite();
    out.insert(out.end(), cells.begin(), cells.end());
  }
  return out;
}

}  // namespace scatmap::tools
