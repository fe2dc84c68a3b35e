#pragma once
#include <vector>

#include "tools/chart/chart.h"

namespace scatmap::tools {

/// Directions to pixels.
std::vector<Chart> chart_inverse(const ChartSettings& settings);

}  // namespace scatmap::tools
