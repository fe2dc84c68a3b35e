#pragma once
#include "scatmap/brdf/signature.h"

namespace scatmap {

/// Part of a frame.
struct FrameWindow {
  int row = 0, column = 0;  ///< first
  int rows = 0, columns = 0;
};

/// The beam's aperture with the background ring around it: all pixels that tell of the beam.
FrameWindow beam_window(const Signature& beam, int frame_rows, int frame_columns);

/// The counts of the window. @pre it lies on the frame
Counts cropped(const Counts& counts, const FrameWindow& window);

}  // namespace scatmap
