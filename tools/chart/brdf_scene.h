#pragma once
#include <vector>

#include "scatmap/angles/instrument.h"
#include "scatmap/brdf/fused.h"

namespace scatmap::tools {

/// One exposure made in memory, for timing and for comparing methods: a peak that saturates, a lobe, a floor a few
/// counts high, hot pixels in one of 10,000, noise of the right size.
struct BrdfScene {
  Instrument instrument;  ///< with a calibration of 17 parameters
  Pose pose;
  std::vector<Frame> frames;
  MasterDark dark;
  SensorModel sensor;
  PixelResponse response;
  double exposure_s = 0.05;
  double factor = 3e-7;

  FusedFrames fused_frames() const { return {frames, dark, sensor, response, exposure_s, factor}; }
};

BrdfScene brdf_scene(const Instrument& instrument, const Pose& pose, int frames);

}  // namespace scatmap::tools
