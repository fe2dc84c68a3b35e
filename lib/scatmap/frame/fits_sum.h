#pragma once
#include <cstdint>
#include <span>

#include "scatmap/base/mask.h"

namespace scatmap {

/// DATASUM of an image's data (FITS standard 4.0, section 4.4.2.7): the ones' complement sum of its big-endian 32-bit
/// words, padding (zeros) included, computed from the pixels in memory.
std::uint32_t fits_sum_of_doubles(std::span<const double> pixels);
std::uint32_t fits_sum_of_floats(std::span<const float> pixels);
/// As 16 bit words.
std::uint32_t fits_sum_of_masks(std::span<const Mask> pixels);

/// Of bytes, four to a word. @pre a multiple of four
std::uint32_t fits_sum_of_bytes(std::span<const char> bytes);

/// A sum of sums, of parts that begin at whole words.
std::uint32_t fits_sum_folded(std::uint64_t sum);

}  // namespace scatmap
