#pragma once
#include <vector>

#include "tools/chart/chart.h"

namespace scatmap::tools {

/// Centroids of simulated spots of 1e3 to 1e7 electrons: time per spot against the centroid's error over the Cramér-Rao
/// bound. Only the settings' time is used.
std::vector<Chart> chart_spots(const ChartSettings& settings);

}  // namespace scatmap::tools
