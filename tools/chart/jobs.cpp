#include "tools/chart/jobs.h"

#include <array>

#include "tools/chart/angles.h"
#include "tools/chart/brdf.h"
#include "tools/chart/calibrate.h"
#include "tools/chart/inverse.h"
#include "tools/chart/lens.h"
#include "tools/chart/model.h"
#include "tools/chart/spots.h"
#include "tools/chart/uncertainty.h"

namespace scatmap::tools {

std::span<const ChartJob> chart_jobs() {
  static constexpr std::array kJobs{
      ChartJob{"angles", chart_angles}, ChartJob{"inverse", chart_inverse},
      ChartJob{"lens", chart_lens},     ChartJob{"model", chart_model},
      ChartJob{"brdf", chart_brdf},     ChartJob{"uncertainty", chart_uncertainty},
      ChartJob{"spots", chart_spots},   ChartJob{"calibrate", chart_calibrate},
  };
  return kJobs;
}

}  // namespace scatmap::tools
