#pragma once
#include "scatmap/brdf/brdf_map.h"
#include "scatmap/model/model.h"

namespace scatmap {

/// A model evaluated on the pixel directions of an instrument at a pose: the same pixels a measured map has. Point
/// values at pixel centres, `exact` method. Below the horizon or behind the detector: NaN and mask. Uncertainties stay
/// empty.
/// @throws Error if the pose is impossible
BrdfMap model_map(const Model& model, const Instrument& instrument, const Pose& pose);

}  // namespace scatmap
