#pragma once
#include <span>

#include "scatmap/base/mask.h"

namespace scatmap {

/// Pixels as FITS stores them: big-endian, one after the other from `to` on.
void fits_bytes_of_doubles(std::span<const double> pixels, unsigned char* to);
void fits_bytes_of_floats(std::span<const float> pixels, unsigned char* to);
void fits_bytes_of_masks(std::span<const Mask> pixels, unsigned char* to);

/// Pixels times a factor, in the type of the file.
void scale_pixels(std::span<const double> pixels, double factor, double* to);
void scale_pixels(std::span<const double> pixels, double factor, float* to);

}  // namespace scatmap
