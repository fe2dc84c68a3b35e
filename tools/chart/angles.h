#pragma once
#include <vector>

#include "tools/chart/chart.h"

namespace scatmap::tools {

/// Methods of the angle map: both scatter angles of every pixel.
std::vector<Chart> chart_angles(const ChartSettings& settings);

}  // namespace scatmap::tools
