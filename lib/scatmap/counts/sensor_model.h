#pragma once
#include <vector>

#include "scatmap/base/grid.h"
#include "scatmap/base/mask.h"
#include "scatmap/frame/frame.h"

namespace scatmap {

/// What counts needs to know of a sensor; every number stated, none guessed.
struct SensorModel {
  double gain_e_per_dn = 0;
  double read_noise_e = 0;
  double saturation_dn = 0;       ///< raw counts at or above it are saturated
  double bias_dn = 0;             ///< zero point of the linearity polynomial
  std::vector<double> linearity;  ///< corrected = bias + x (1 + c0 x + c1 x² + …), x = raw − bias, DN

  double read_noise_dn() const { return read_noise_e / gain_e_per_dn; }
  /// Raw DN to linearised DN.
  double linearised(double raw_dn) const;
};

/// Pixels the user knows to be bad, and the sensor's relative response.
struct PixelResponse {
  Grid<Mask> bad;    ///< kBad where listed; empty: none
  Grid<float> flat;  ///< relative response, mean 1 over its positive pixels; empty: uniform
};

/// A flat field from a frame: divided by the mean of its positive finite pixels. Pixels that are not positive stay as
/// they are and are masked kFlatInvalid by `reduce`. @throws Error if no pixel is positive
Grid<float> normalised_flat(const Frame& flat);

/// kBad where the frame is not 0.
Grid<Mask> bad_pixels_from_frame(const Frame& frame);

/// kBad at the pixels of a CSV list with header "column_px,row_px" (integers, (0, 0) first). @throws Error with the
/// line
Grid<Mask> read_bad_pixel_list(const std::filesystem::path& path, int rows, int columns);

}  // namespace scatmap
