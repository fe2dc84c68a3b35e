#pragma once
#include <filesystem>

#include "scatmap/frame/frame.h"

namespace scatmap {

/// Reads a plain FITS image (see frame.h): the structure is checked first, and only then does CFITSIO open the file.
/// @throws Error with the true reason
Frame read_fits(const std::filesystem::path& path);

}  // namespace scatmap
