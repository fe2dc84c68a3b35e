#include "tools/chart/jobs.h"

#include <array>

#include "tools/chart/angles.h"
#include "tools/chart/uncertainty.h"
#include "tools/chart/model.h"

namespace scatmap::tools {

std::span<const ChartJob> chart_jobs() {
  static constexpr std::array kJobs{
      ChartJob{"angles", chart_angles},
      ChartJob{"uncertainty", chart_uncertainty},
      ChartJob{"model", chart_model},
  };
  return kJobs;
}

}  // namespace scatmap::tools
