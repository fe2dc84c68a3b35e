#pragma once
#include <string>

namespace scatmap {

/// Checks what a file says of its size before anything is allocated for it.
/// @param file name for the message; columns, rows: as the file states them
/// @throws Error unless both are at least 1 and their product is at most kMaxFramePixels
void check_frame_size(const std::string& file, long long columns, long long rows);

/// Most pixels a byte of LZW, Deflate or PackBits data can stand for (Deflate: 1032, LZW: about 1320), rounded up.
inline constexpr long long kMaxPixelsPerFileByte = 4096;

/// For compressed formats, where the size of the file does not tell the number of pixels: refuses a small file that
/// asks for a large frame. @throws Error
void check_enough_data(const std::string& file, long long pixels, long long file_bytes);

}  // namespace scatmap
