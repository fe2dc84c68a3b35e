#pragma once
#include <cstdint>
#include <filesystem>
#include <span>

#include "scatmap/base/provenance.h"
#include "scatmap/frame/fits_structure.h"

namespace scatmap {

/// Reads the pixels of a checked image of BITPIX 8 or 16 in big blocks: DN = stored value + zero.
/// @param dn as many as the image has; @param hash takes the whole file's bytes; nullptr: not wanted
/// @throws Error if the file cannot be read or has become shorter
void read_fits_pixels(const std::filesystem::path& path, const FitsHdu& image, float zero_dn, std::span<float> dn,
                      InputHash* hash);

/// The same for 16-bit images of BZERO 32768: whole numbers without a sign.
void read_fits_pixels(const std::filesystem::path& path, const FitsHdu& image, std::span<std::uint16_t> dn,
                      InputHash* hash);

/// Stored pixels to DN: bytes as they are, or 16 bit with sign, high byte first. 0 <= pixels.
void decode_bytes(const unsigned char* bytes, float zero_dn, long long pixels, float* dn);
void decode_words(const unsigned char* bytes, float zero_dn, long long pixels, float* dn);
/// 16 bit with sign, high byte first, to DN = stored + 32768.
void decode_unsigned_words(const unsigned char* bytes, long long pixels, std::uint16_t* dn);

}  // namespace scatmap
