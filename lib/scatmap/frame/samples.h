#pragma once
#include <cstddef>
#include <span>

namespace scatmap {

/// Unsigned samples as PNG and PGM store them: one byte, or two bytes with the high byte first.
/// @param bytes_per_sample 1 or 2; bytes: values.size()·bytes_per_sample of them; values: filled, DN
inline void unpack_samples(const unsigned char* bytes, int bytes_per_sample, std::span<float> values) {
  if (bytes_per_sample == 1) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(bytes[i]);
  } else {
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = static_cast<float>((bytes[2 * i] << 8) | bytes[2 * i + 1]);
    }
  }
}

}  // namespace scatmap
