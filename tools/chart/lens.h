#pragma once
#include <vector>

#include "tools/chart/chart.h"

namespace scatmap::tools {

/// Rays and angles behind an 8-parameter lens.
std::vector<Chart> chart_lens(const ChartSettings& settings);

}  // namespace scatmap::tools
