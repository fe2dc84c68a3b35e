#include "tools/chart/jobs.h"

#include <array>

#include "tools/chart/angles.h"
#include "tools/chart/inverse.h"
#include "tools/chart/lens.h"

namespace scatmap::tools {

std::span<const ChartJob> chart_jobs() {
  static constexpr std::array kJobs{
      ChartJob{"angles", chart_angles},
      ChartJob{"inverse", chart_inverse},
      ChartJob{"lens", chart_lens},
  };
  return kJobs;
}

}  // namespace scatmap::tools
