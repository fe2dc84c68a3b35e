#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "scatmap/base/file_state.h"
#include "scatmap/base/provenance.h"
#include "scatmap/frame/raw_counts.h"

namespace scatmap {

/// What the file itself says of the exposure; absent when it says nothing. Nothing is guessed.
struct FrameHeader {
  std::optional<double> exposure_s;       ///< EXPTIME, or EXPOSURE
  std::optional<double> gain_e_per_dn;    ///< EGAIN only: GAIN may be a camera setting, so it is never read as e-/DN
  std::optional<double> saturation_dn;    ///< SATURATE
  std::optional<double> stage_deg;        ///< STAGEDEG
  std::optional<double> arm_deg;          ///< ARMDEG
  std::optional<double> tilt_deg;         ///< TILTDEG: known out-of-plane tilt of a mirror
  std::optional<std::string> target;      ///< TARGET, as written: "specular" or "direct" where it speaks of a beam
  std::optional<std::string> image_type;  ///< IMAGETYP, as written: "Light Frame", "Dark Frame", ...
  std::optional<std::string> row_order;   ///< ROWORDER: "TOP-DOWN" or "BOTTOM-UP"
  std::optional<std::string> date;        ///< DATE-OBS
};

/// One raw frame: counts as stored, first pixel stored at (0, 0), no flip applied.
struct Frame {
  RawCounts dn;           ///< rows × columns, DN. Exact: integers beyond 2^24 are refused.
  double quantum_dn = 1;  ///< step between neighbouring values; 0 for floating-point files
  std::filesystem::path file;
  FrameHeader header;
  FileState state{};  ///< of the file when it was read
};

/// Most pixels a frame may have: 2^30 (a 32768 × 32768 sensor).
inline constexpr long long kMaxFramePixels = 1LL << 30;

/// Refuses what is no readable FITS file by its first bytes, with the true reason: missing, folder, empty, compressed,
/// text.
/// @throws Error
void require_fits_file(const std::filesystem::path& path);

/// Reads a raw frame by its content, not its name: FITS (plain images of BITPIX 8, 16, 32, −32, −64; the primary image,
/// or the only image extension), TIFF (one page, grey, 8 or 16 bit unsigned or 32 bit float), PNG (grey, 8 or 16 bit),
/// PGM (P5, maxval to 65535, and P2). Nothing is scaled but FITS BZERO/BSCALE; FITS BLANK becomes NaN.
/// @throws Error with the true reason: missing, empty, truncated, compressed, colour, several images, wrong type, a map
/// of scatmap, changed while it was read
Frame read_frame(const std::filesystem::path& path);

/// A frame and the checksum of the file it came from; a plain FITS file is read once for both.
struct RecordedFrame {
  Frame frame;
  InputRecord record;
};
/// @throws Error as read_frame
RecordedFrame read_recorded_frame(const std::filesystem::path& path);

}  // namespace scatmap
