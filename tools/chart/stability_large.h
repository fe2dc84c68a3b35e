#pragma once
#include <vector>

#include "tools/chart/stability.h"

namespace scatmap::tools {

/// The regime of a frame of 16384 × 16384 pixels, whose maps would take gigabytes: rows and bands at its edges, in its
/// middle and between.
std::vector<StabilityCell> large_angles();
std::vector<StabilityCell> large_inverse();

}  // namespace scatmap::tools
