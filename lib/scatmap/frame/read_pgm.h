#pragma once
#include <filesystem>

#include "scatmap/frame/frame.h"

namespace scatmap {

/// Reads a PGM image: P5 (one byte per sample to maxval 255, two bytes high byte first above) or P2 (text). Counts are
/// not scaled by maxval; one above it is an error, and so is anything after the pixels.
/// @throws Error with the true reason
Frame read_pgm(const std::filesystem::path& path);

}  // namespace scatmap
