#pragma once
#include <filesystem>

#include "scatmap/frame/fits_structure.h"

namespace scatmap {

/// Holds an HDU's data to its DATASUM (FITS standard 4.0, section 4.4.2.7), where the header states one.
/// @throws Error naming file and card if the sum is another or no number, or the file cannot be read
void require_fits_data_sum(const std::filesystem::path& path, const FitsHdu& hdu);

/// The same, and the whole HDU to its CHECKSUM: ones' complement sum of all words −0.
void require_fits_sums(const std::filesystem::path& path, const FitsHdu& hdu);

}  // namespace scatmap
