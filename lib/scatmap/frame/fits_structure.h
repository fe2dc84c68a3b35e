#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scatmap/frame/fits_header.h"

namespace scatmap {

/// Bytes of one FITS block: headers and data fill whole blocks.
inline constexpr long long kFitsBlockBytes = 2880;
/// Most header blocks of a file, over all its HDUs (36,000 cards).
inline constexpr int kMaxFitsHeaderBlocks = 1000;
/// Most axes and longest axis of any HDU.
inline constexpr long long kMaxFitsAxes = 8;
inline constexpr long long kMaxFitsAxis = 2147483647;
/// Most columns of a table (standard, section 7).
inline constexpr long long kMaxFitsColumns = 999;

/// One header and its data, as far as the layout of the file goes.
struct FitsHdu {
  FitsHeader header;
  std::string name;             ///< EXTNAME, "primary", or "HDU n"
  bool image = false;           ///< primary or IMAGE extension, with at least one pixel
  int bitpix = 0;               ///< 8, 16, 32, -32 or -64
  std::vector<long long> axes;  ///< NAXIS1, NAXIS2, …
  long long offset = 0;         ///< of the header's first byte in the file
  long long data_bytes = 0;     ///< without the padding
  long long data_offset = 0;    ///< of the data's first byte in the file

  long long padded_bytes() const { return (data_bytes + kFitsBlockBytes - 1) / kFitsBlockBytes * kFitsBlockBytes; }
};

/// Walks a FITS file from header to header and holds its layout to the FITS standard (4.0, sections 3 and 4.4) before
/// CFITSIO sees it: CFITSIO trusts what a header says, and has crashed on tile-compressed files that lie.
/// Bytes after the last HDU that do not begin an extension are tolerated.
/// @return every HDU in order, the primary first
/// @throws Error naming file, HDU and card: no END, wrong order, duplicate or contradicting keywords, BITPIX or NAXIS
/// out of range, data that the file is too short for, random groups, tile compression,
/// a table without TFIELDS from 0 to 999
std::vector<FitsHdu> check_fits_structure(const std::filesystem::path& path);

}  // namespace scatmap
