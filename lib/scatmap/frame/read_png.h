#pragma once
#include <filesystem>

#include "scatmap/frame/frame.h"

namespace scatmap {

/// Reads a grey PNG of 8 or 16 bit without transparency, interlaced or not. Gamma and colour chunks are ignored: the
/// stored counts are returned.
/// @throws Error with the true reason
Frame read_png(const std::filesystem::path& path);

}  // namespace scatmap
