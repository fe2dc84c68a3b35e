#include "scatmap/frame/fits_sum.h"

#include <bit>
#include <cstring>

#include "scatmap/base/simd.h"

namespace scatmap {
namespace {

// A ones' complement sum is any sum with its carries folded in; 2^32 pixels do not overflow 64 bits.
std::uint32_t folded(std::uint64_t sum) {
  while ((sum >> 32) != 0) sum = (sum & 0xffffffffu) + (sum >> 32);
  return static_cast<std::uint32_t>(sum);
}

}  // namespace

SCATMAP_CLONES std::uint32_t fits_sum_of_doubles(std::span<const double> pixels) {
  std::uint64_t high = 0, low = 0;
  for (const double v : pixels) {
    const auto bits = std::bit_cast<std::uint64_t>(v);
    high += bits >> 32;
    low += bits & 0xffffffffu;
  }
  return folded(static_cast<std::uint64_t>(folded(high)) + folded(low));
}

SCATMAP_CLONES std::uint32_t fits_sum_of_floats(std::span<const float> pixels) {
  std::uint64_t sum = 0;
  for (const float v : pixels) sum += std::bit_cast<std::uint32_t>(v);
  return folded(sum);
}

SCATMAP_CLONES std::uint32_t fits_sum_of_masks(std::span<const Mask> pixels) {
  std::uint64_t first = 0, second = 0;  // of each pair
  const std::size_t pairs = pixels.size() / 2;
  for (std::size_t i = 0; i < pairs; ++i) {
    first += pixels[2 * i];
    second += pixels[2 * i + 1];
  }
  if (pixels.size() % 2 == 1) first += pixels.back();
  return folded((static_cast<std::uint64_t>(folded(first)) << 16) + folded(second));
}

SCATMAP_CLONES std::uint32_t fits_sum_of_bytes(std::span<const char> bytes) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < bytes.size() / 4; ++i) {
    std::uint32_t word;
    std::memcpy(&word, bytes.data() + 4 * i, sizeof word);
    if constexpr (std::endian::native == std::endian::little) word = __builtin_bswap32(word);
    sum += word;
  }
  return folded(sum);
}

std::uint32_t fits_sum_folded(std::uint64_t sum) { return folded(sum); }

}  // namespace scatmap
