#pragma once
#include <filesystem>

#include "scatmap/frame/frame.h"

namespace scatmap {

/// Reads a one-page grey TIFF stored in strips: 8 or 16 bit unsigned or 32 bit float, uncompressed, LZW, Deflate or
/// PackBits. Refused: tiles, several pages, colour, palettes, min-is-white, and any orientation but top-left, because
/// a flip changes the sign of phi.
/// @throws Error with the true reason
Frame read_tiff(const std::filesystem::path& path);

}  // namespace scatmap
