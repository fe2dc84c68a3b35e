#pragma once
#include "scatmap/angles/pixel_plane.h"
#include "scatmap/model/model.h"

namespace scatmap::tools {

/// BRDF of one pixel, 1/sr, by the equations as they stand in the paper: angles by acos and atan2, std::complex
/// polarisation factors, a rotation per tilted term. What a straightforward program does; double throughout, compiled
/// with the product's flags. A rival for the chart, not for use: acos loses digits at the peak.
double naive_model(const Model& model, const SampleView& view, double detector_distance_m, int column, int row);

}  // namespace scatmap::tools
