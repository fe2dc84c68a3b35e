#pragma once
#include <span>
#include <string_view>

#include "tools/chart/chart.h"

namespace scatmap::tools {

/// A job with more than one method.
struct ChartJob {
  std::string_view name;
  std::vector<Chart> (*measure)(const ChartSettings&);  ///< one chart or more
};

/// All jobs, in the order in which `chart all` measures them.
std::span<const ChartJob> chart_jobs();

}  // namespace scatmap::tools
