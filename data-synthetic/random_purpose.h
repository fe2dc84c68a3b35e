#pragma once
#include <cstdint>

namespace scatmap::synth {

/// What a scene draws random numbers for; one independent family each. Values are part of a scene's result: add, never
/// renumber.
enum RandomPurpose : std::uint64_t {
  kPhotons = 1,
  kReadNoise = 2,
  kHotPixels = 3,
  kEncoders = 4,
  kCentroids = 5,
  kPixelGains = 6,
};

}  // namespace scatmap::synth
