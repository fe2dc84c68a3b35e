#pragma once
#include <vector>

#include "tools/chart/chart.h"

namespace scatmap::tools {

/// Methods of counts → BRDF: from raw frames in memory to the map with its uncertainties and mask.
std::vector<Chart> chart_brdf(const ChartSettings& settings);

}  // namespace scatmap::tools
