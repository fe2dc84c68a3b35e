#pragma once
#include <cstddef>
#include <string>

/// FITS files as bytes, as an editor leaves them that drops CHECKSUM and DATASUM: empty HISTORY cards stand there.
inline std::string without_fits_sums(std::string bytes) {
  constexpr std::size_t kCard = 80;
  const std::string empty = "HISTORY" + std::string(kCard - 7, ' ');
  for (std::size_t at = 0; at + kCard <= bytes.size(); at += kCard) {
    if (bytes.compare(at, 9, "CHECKSUM=") == 0 || bytes.compare(at, 9, "DATASUM =") == 0)
      bytes.replace(at, kCard, empty);
  }
  return bytes;
}
