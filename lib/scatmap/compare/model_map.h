#pragma once
#include "scatmap/brdf/brdf_map.h"
#include "scatmap/model/frame_model.h"
#include "scatmap/model/model.h"

namespace scatmap {

/// A model evaluated on the pixel directions of an instrument at a pose: the same pixels a measured map has. By default
/// values at pixel centres by the `exact` method. Below the horizon or behind the detector: NaN and mask. Uncertainties
/// stay empty; a note in the map says which method was used and its bound. Directions come from the pixel plane itself,
/// never from angles.
/// @throws Error if the pose is impossible
BrdfMap model_map(const Model& model, const Instrument& instrument, const Pose& pose,
                  const FrameModelOptions& options = {});

/// The options' bound: relative error to the larger of the value and kPeakShare of the frame's largest, apart from
/// model_rounding_error().
double model_error_bound(const FrameModelOptions& options);

}  // namespace scatmap
