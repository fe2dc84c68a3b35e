#pragma once
#include <vector>

#include "tools/chart/chart.h"

namespace scatmap::tools {

/// Calibration of 80 targets on benches drawn from the mechanical tolerances, stage zero known by autocollimation: time
/// against the direction error at the frame's corners, and against how far the stated uncertainty of those directions
/// is from the observed one. The settings' instrument and pose are not used.
std::vector<Chart> chart_calibrate(const ChartSettings& settings);

}  // namespace scatmap::tools
