#include <array>
#include <fstream>
#include <string_view>

#include "scatmap/base/error.h"
#include "scatmap/frame/frame.h"
#include "scatmap/frame/read_fits.h"
#include "scatmap/frame/read_pgm.h"
#include "scatmap/frame/read_png.h"
#include "scatmap/frame/read_tiff.h"

namespace scatmap {
namespace {

using namespace std::string_view_literals;

using Reader = Frame (*)(const std::filesystem::path&);

struct ReadableFormat {
  std::string_view magic;
  Reader read;
};

constexpr std::array kReadable{
    ReadableFormat{"SIMPLE"sv, read_fits}, ReadableFormat{"II*\0"sv, read_tiff},
    ReadableFormat{"MM\0*"sv, read_tiff},  ReadableFormat{"II+\0"sv, read_tiff},
    ReadableFormat{"MM\0+"sv, read_tiff},  ReadableFormat{"\x89PNG\r\n\x1a\n"sv, read_png},
    ReadableFormat{"P2"sv, read_pgm},      ReadableFormat{"P5"sv, read_pgm},
};

struct RefusedFormat {
  std::string_view magic;
  const char* reason;
};

// Named so that the user learns what the file is instead of what it is not.
constexpr std::array kRefused{
    RefusedFormat{"\x1f\x8b"sv, "is gzip-compressed; decompress it first"},
    RefusedFormat{"\x1f\x9d"sv, "is compressed by compress (.Z); decompress it first"},
    RefusedFormat{"BZh"sv, "is bzip2-compressed; decompress it first"},
    RefusedFormat{"\xfd"
                  "7zXZ"sv,
                  "is xz-compressed; decompress it first"},
    RefusedFormat{"\x28\xb5\x2f\xfd"sv, "is zstd-compressed; decompress it first"},
    RefusedFormat{"PK\x03\x04"sv, "is a zip archive; unpack it first"},
    RefusedFormat{"XTENSION"sv, "begins with a FITS extension, without the primary header"},
    RefusedFormat{"\x89PNG"sv, "is a PNG damaged by a text-mode transfer"},
    RefusedFormat{"\xff\xd8\xff"sv, "is a JPEG: lossy, its counts are not the camera's"},
    RefusedFormat{"P1"sv, "is a PBM bitmap: one bit per pixel"},
    RefusedFormat{"P4"sv, "is a PBM bitmap: one bit per pixel"},
    RefusedFormat{"P3"sv, "is a colour image (PPM)"},
    RefusedFormat{"P6"sv, "is a colour image (PPM)"},
    RefusedFormat{"P7"sv, "is a PAM image"},
    RefusedFormat{"\x76\x2f\x31\x01"sv, "is an OpenEXR image: a result, not a raw frame"},
    RefusedFormat{"\x89HDF"sv, "is an HDF5 file"},
    RefusedFormat{"\x93NUMPY"sv, "is a NumPy array"},
};

// CFITSIO, libtiff and libpng would each say this in their own way, or wait for ever on a pipe.
void check_is_file(const std::filesystem::path& path) {
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  const std::string file = path.string();
  if (status.type() == std::filesystem::file_type::not_found) throw Error({file, "does not exist", "", ""});
  if (failure) throw Error({file, "cannot be read", failure.message(), ""});
  if (std::filesystem::is_directory(status)) throw Error({file, "is a folder, not a file", "", ""});
  if (!std::filesystem::is_regular_file(status)) throw Error({file, "is not a regular file", "", ""});
}

std::string first_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error({path.string(), "cannot be opened for reading", "", ""});
  std::string bytes(8, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (in.bad()) throw Error({path.string(), "cannot be read", "", ""});
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  if (bytes.empty()) throw Error({path.string(), "is empty", "", ""});
  return bytes;
}

void refuse_known_format(const std::filesystem::path& path, const std::string& begin) {
  for (const auto& format : kRefused) {
    if (begin.starts_with(format.magic)) throw Error({path.string(), format.reason, "", ""});
  }
}

}  // namespace

void require_fits_file(const std::filesystem::path& path) {
  check_is_file(path);
  const std::string begin = first_bytes(path);
  if (begin.starts_with("SIMPLE")) return;
  refuse_known_format(path, begin);
  throw Error({path.string(), "is not a FITS file", "", ""});
}

RecordedFrame read_recorded_frame(const std::filesystem::path& path) {
  check_is_file(path);
  const FileState before = file_state(path);
  if (first_bytes(path).starts_with("SIMPLE")) {
    RecordedFrame out = read_recorded_fits(path);
    require_unchanged(path, before);
    out.frame.state = before;
    return out;
  }
  Frame frame = read_frame(path);
  InputRecord record = record_input(path, frame.state);
  return {std::move(frame), std::move(record)};
}

Frame read_frame(const std::filesystem::path& path) {
  check_is_file(path);
  const FileState before = file_state(path);
  const std::string begin = first_bytes(path);
  for (const auto& format : kReadable) {
    if (!begin.starts_with(format.magic)) continue;
    Frame frame = format.read(path);
    require_unchanged(path, before);
    frame.state = before;
    return frame;
  }
  refuse_known_format(path, begin);
  throw Error({path.string(), "is not a frame scatmap can read", "", "FITS, TIFF, PNG or PGM"});
}

}  // namespace scatmap
