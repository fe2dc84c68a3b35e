#pragma once
#include <vector>

#include "tools/chart/chart.h"

namespace scatmap::tools {

/// Methods of the model over a frame: values at pixel centres, and means over pixels.
std::vector<Chart> chart_model(const ChartSettings& settings);

}  // namespace scatmap::tools
