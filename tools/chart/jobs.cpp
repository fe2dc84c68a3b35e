#include "tools/chart/jobs.h"

#include <array>

#include "tools/chart/angles.h"
#include "tools/chart/brdf.h"

namespace scatmap::tools {

std::span<const ChartJob> chart_jobs() {
  static constexpr std::array kJobs{
      ChartJob{"angles", chart_angles},
      ChartJob{"brdf", chart_brdf},
  };
  return kJobs;
}

}  // namespace scatmap::tools
