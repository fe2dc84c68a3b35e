#include "scatmap/report/fits_bytes.h"

#include <bit>
#include <cstdint>
#include <cstring>

#include "scatmap/base/simd.h"

namespace scatmap {
namespace {

constexpr bool kSwap = std::endian::native == std::endian::little;

}  // namespace

SCATMAP_CLONES void fits_bytes_of_doubles(std::span<const double> pixels, unsigned char* to) {
  const double* from = pixels.data();
  const std::size_t n = pixels.size();
  SCATMAP_INDEPENDENT
  for (std::size_t i = 0; i < n; ++i) {
    std::uint64_t word = std::bit_cast<std::uint64_t>(from[i]);
    if constexpr (kSwap) word = __builtin_bswap64(word);
    std::memcpy(to + 8 * i, &word, sizeof word);
  }
}

SCATMAP_CLONES void fits_bytes_of_floats(std::span<const float> pixels, unsigned char* to) {
  const float* from = pixels.data();
  const std::size_t n = pixels.size();
  SCATMAP_INDEPENDENT
  for (std::size_t i = 0; i < n; ++i) {
    std::uint32_t word = std::bit_cast<std::uint32_t>(from[i]);
    if constexpr (kSwap) word = __builtin_bswap32(word);
    std::memcpy(to + 4 * i, &word, sizeof word);
  }
}

SCATMAP_CLONES void fits_bytes_of_masks(std::span<const Mask> pixels, unsigned char* to) {
  const Mask* from = pixels.data();
  const std::size_t n = pixels.size();
  SCATMAP_INDEPENDENT
  for (std::size_t i = 0; i < n; ++i) {
    std::uint16_t word = from[i];
    if constexpr (kSwap) word = __builtin_bswap16(word);
    std::memcpy(to + 2 * i, &word, sizeof word);
  }
}

SCATMAP_CLONES void scale_pixels(std::span<const double> pixels, double factor, double* to) {
  const double* from = pixels.data();
  const std::size_t n = pixels.size();
  SCATMAP_INDEPENDENT
  for (std::size_t i = 0; i < n; ++i) to[i] = from[i] * factor;
}

SCATMAP_CLONES void scale_pixels(std::span<const double> pixels, double factor, float* to) {
  const double* from = pixels.data();
  const std::size_t n = pixels.size();
  SCATMAP_INDEPENDENT
  for (std::size_t i = 0; i < n; ++i) to[i] = static_cast<float>(from[i] * factor);
}

}  // namespace scatmap
