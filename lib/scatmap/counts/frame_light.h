#pragma once
#include <cstddef>

#include "scatmap/base/grid.h"
#include "scatmap/frame/raw_counts.h"

namespace scatmap {

/// What a raw frame says as a whole, before anything is done to it. NaN counts as absent.
struct FrameLight {
  double sum_dn = 0;           ///< over all pixels, as stored
  float largest_dn = 0;        ///< 0 where no pixel has a value
  std::size_t at_largest = 0;  ///< pixels with that very value: many where something clips
};

/// One pass over the pixels, by rows: the same at any number of threads.
FrameLight frame_light(const Grid<float>& dn);
FrameLight frame_light(const RawCounts& dn);

}  // namespace scatmap
