#include <bit>
#include <cstdint>
#include <cstring>

#include "scatmap/base/simd.h"
#include "scatmap/frame/fits_pixels.h"

namespace scatmap {

SCATMAP_CLONES void decode_bytes(const unsigned char* bytes, float zero_dn, long long pixels, float* dn) {
  SCATMAP_INDEPENDENT
  for (long long i = 0; i < pixels; ++i) dn[i] = static_cast<float>(bytes[i]) + zero_dn;
}

namespace {

// High byte first.
SCATMAP_INLINE std::uint16_t word_at(const unsigned char* bytes, long long i) {
  std::uint16_t word;
  std::memcpy(&word, bytes + 2 * i, sizeof word);
  if constexpr (std::endian::native == std::endian::little)
    word = static_cast<std::uint16_t>((word << 8) | (word >> 8));
  return word;
}

}  // namespace

SCATMAP_CLONES void decode_words(const unsigned char* bytes, float zero_dn, long long pixels, float* dn) {
  SCATMAP_INDEPENDENT
  for (long long i = 0; i < pixels; ++i)
    dn[i] = static_cast<float>(static_cast<std::int16_t>(word_at(bytes, i))) + zero_dn;
}

SCATMAP_CLONES void decode_unsigned_words(const unsigned char* bytes, long long pixels, std::uint16_t* dn) {
  SCATMAP_INDEPENDENT
  for (long long i = 0; i < pixels; ++i) dn[i] = static_cast<std::uint16_t>(word_at(bytes, i) ^ 0x8000U);
}

}  // namespace scatmap
