#pragma once
#include <filesystem>

#include "scatmap/frame/frame.h"

namespace scatmap {

/// Reads a plain FITS image (see frame.h): the structure is checked first, and only then are pixels read. Images of 8
/// and 16 bits without BLANK and with whole BZERO, as cameras write them, are read here; the others by CFITSIO.
/// @throws Error with the true reason
Frame read_fits(const std::filesystem::path& path);

/// The same with the file's checksum.
RecordedFrame read_recorded_fits(const std::filesystem::path& path);

}  // namespace scatmap
