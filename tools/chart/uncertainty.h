#pragma once
#include <vector>

#include "tools/chart/chart.h"

namespace scatmap::tools {

/// Methods of the scale statistics: time of a 95 % interval against how far its true probability is from 95 %. One
/// chart each at the paper's 59.3 % and 14 % worst case, and for a pixel of 4 % standard uncertainty.
std::vector<Chart> chart_uncertainty(const ChartSettings& settings);

}  // namespace scatmap::tools
