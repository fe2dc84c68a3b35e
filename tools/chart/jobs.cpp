#include "tools/chart/jobs.h"

#include <array>

#include "tools/chart/angles.h"

namespace scatmap::tools {

std::span<const ChartJob> chart_jobs() {
  static constexpr std::array kJobs{
      ChartJob{"angles", chart_angles},
  };
  return kJobs;
}

}  // namespace scatmap::tools
