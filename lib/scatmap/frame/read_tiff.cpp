#include "scatmap/frame/read_tiff.h"

#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <fstream>
#include <limits>
#include <memory>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/frame/frame_size.h"

namespace scatmap {
namespace {

struct Message {
  std::array<char, 256> text{};
};

// libtiff's first complaint is the cause; later ones are its consequences. A non-zero return keeps it off stderr.
int keep_first(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  auto& text = static_cast<Message*>(user)->text;
  if (text[0] == '\0') std::vsnprintf(text.data(), text.size(), format, arguments);
  return 1;
}

// Unknown tags are everyday warnings and no reason to refuse a frame.
int drop(TIFF*, void*, const char*, const char*, va_list) { return 1; }

struct Closer {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using TiffFile = std::unique_ptr<TIFF, Closer>;

[[noreturn]] void fail(const std::string& file, const std::string& problem, const Message& message) {
  const std::string cause(message.text.data());
  throw Error({file, problem + (cause.empty() ? "" : ": libtiff says '" + cause + "'"), "", ""});
}

// m: no memory map, a file cut short while it is read must not end the program; c: strips as they are in the file.
TiffFile open(const std::string& file, long long file_bytes, Message& message) {
  constexpr tmsize_t kSlackBytes = 64 << 20;
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  if (options == nullptr) throw std::bad_alloc();
  TIFFOpenOptionsSetMaxSingleMemAlloc(options, static_cast<tmsize_t>(file_bytes) + kSlackBytes);
  TIFFOpenOptionsSetErrorHandlerExtR(options, keep_first, &message);
  TIFFOpenOptionsSetWarningHandlerExtR(options, drop, nullptr);
  TiffFile tiff(TIFFOpenExt(file.c_str(), "rmc", options));
  TIFFOpenOptionsFree(options);
  if (tiff == nullptr) fail(file, "is truncated or not a valid TIFF", message);
  return tiff;
}

template <class T>
std::optional<T> field(TIFF* tiff, uint32_t tag) {
  T value{};
  if (TIFFGetField(tiff, tag, &value) != 1) return std::nullopt;
  return value;
}

std::uint16_t short_field(TIFF* tiff, uint32_t tag, std::uint16_t otherwise) {
  return field<std::uint16_t>(tiff, tag).value_or(otherwise);
}

void check_grey(TIFF* tiff, const std::string& file) {
  const auto photometric = field<std::uint16_t>(tiff, TIFFTAG_PHOTOMETRIC);
  if (!photometric) throw Error({file, "does not say what its values mean", "no PhotometricInterpretation", ""});
  if (*photometric == PHOTOMETRIC_PALETTE) throw Error({file, "has a colour palette, not grey values", "", ""});
  if (*photometric == PHOTOMETRIC_MINISWHITE) throw Error({file, "is stored inverted (min-is-white)", "", ""});
  const auto samples = short_field(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  if (*photometric != PHOTOMETRIC_MINISBLACK) {
    throw Error(
        {file, "is a colour image, not grey",
         "PhotometricInterpretation " + std::to_string(*photometric) + ", " + std::to_string(samples) + " samples",
         "min-is-black (1)"});
  }
  if (samples != 1) throw Error({file, "has several samples per pixel", std::to_string(samples), "1"});
}

void check_sample_type(TIFF* tiff, const std::string& file) {
  const auto bits = short_field(tiff, TIFFTAG_BITSPERSAMPLE, 1);
  const auto format = short_field(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  const bool readable =
      (format == SAMPLEFORMAT_UINT && (bits == 8 || bits == 16)) || (format == SAMPLEFORMAT_IEEEFP && bits == 32);
  if (readable) return;
  const char* kind = format == SAMPLEFORMAT_UINT     ? "unsigned"
                     : format == SAMPLEFORMAT_INT    ? "signed"
                     : format == SAMPLEFORMAT_IEEEFP ? "floating-point"
                                                     : "unknown";
  throw Error({file, "has samples scatmap does not read", std::to_string(bits) + " bit " + kind,
               "8 or 16 bit unsigned or 32 bit floating-point"});
}

void check_compression(TIFF* tiff, const std::string& file) {
  const auto compression = short_field(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  for (const int known :
       {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_DEFLATE, COMPRESSION_PACKBITS}) {
    if (compression == known) return;
  }
  const bool jpeg = compression == COMPRESSION_JPEG || compression == COMPRESSION_OJPEG;
  throw Error(
      {file,
       jpeg ? "is JPEG-compressed: lossy, its counts are not the camera's" : "has a compression scatmap does not read",
       "scheme " + std::to_string(compression), "none, LZW, Deflate or PackBits"});
}

std::uint64_t number_at(std::ifstream& in, std::uint64_t at, std::size_t bytes, bool big_endian) {
  std::array<unsigned char, 8> raw{};
  in.seekg(static_cast<std::streamoff>(at));
  in.read(reinterpret_cast<char*>(raw.data()), static_cast<std::streamsize>(bytes));
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | raw[big_endian ? i : bytes - 1 - i];
  return value;
}

// libtiff takes a missing link to the next page for "no next page", so a file cut there would pass for whole.
void check_directory_is_whole(TIFF* tiff, const std::string& file, long long file_bytes) {
  const bool big_tiff = TIFFIsBigTIFF(tiff) != 0;
  std::ifstream in(file, std::ios::binary);
  const std::uint64_t at = TIFFCurrentDirOffset(tiff);
  const std::uint64_t entries = number_at(in, at, big_tiff ? 8 : 2, TIFFIsBigEndian(tiff) != 0);
  const std::uint64_t end = at + (big_tiff ? 8 + 20 * entries + 8 : 2 + 12 * entries + 4);
  if (!in || end > static_cast<std::uint64_t>(file_bytes)) {
    throw Error({file, "is truncated at the end of its directory", std::to_string(file_bytes) + " bytes",
                 "at least " + std::to_string(end)});
  }
}

void check_layout(TIFF* tiff, const std::string& file) {
  if (TIFFLastDirectory(tiff) == 0) {
    const auto pages = TIFFNumberOfDirectories(tiff);
    throw Error({file, "holds several pages", pages > 1 ? std::to_string(pages) : "a damaged second page", "one page"});
  }
  if (TIFFIsTiled(tiff) != 0) throw Error({file, "is stored in tiles", "", "strips"});
  const auto orientation = short_field(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  if (orientation != ORIENTATION_TOPLEFT) {
    throw Error({file, "is flipped or rotated: a flip changes the sign of phi",
                 "Orientation " + std::to_string(orientation), "top-left (1)"});
  }
}

void read_strip(TIFF* tiff, std::uint32_t strip, void* to, tmsize_t bytes, const std::string& file, const Message& m) {
  const tmsize_t got = TIFFReadEncodedStrip(tiff, strip, to, bytes);
  if (got == bytes) return;
  fail(file, "is truncated or damaged in strip " + std::to_string(strip), m);
}

template <class T>
void read_strips(TIFF* tiff, Grid<float>& dn, std::uint32_t rows_per_strip, const std::string& file, const Message& m) {
  const auto columns = static_cast<std::size_t>(dn.columns());
  const auto rows = static_cast<std::uint32_t>(dn.rows());
  std::vector<T> strip(columns * rows_per_strip);
  for (std::uint32_t first = 0; first < rows; first += rows_per_strip) {
    const std::size_t count = std::min(rows_per_strip, rows - first) * columns;
    read_strip(tiff, first / rows_per_strip, strip.data(), static_cast<tmsize_t>(count * sizeof(T)), file, m);
    float* out = dn.data() + first * columns;
    for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<float>(strip[i]);
  }
}

}  // namespace

Frame read_tiff(const std::filesystem::path& path) {
  const std::string file = path.string();
  const auto file_bytes = static_cast<long long>(std::filesystem::file_size(path));
  Message message;
  const TiffFile owner = open(file, file_bytes, message);
  TIFF* tiff = owner.get();
  check_directory_is_whole(tiff, file, file_bytes);
  check_layout(tiff, file);
  check_grey(tiff, file);
  check_sample_type(tiff, file);
  check_compression(tiff, file);
  const auto columns = field<std::uint32_t>(tiff, TIFFTAG_IMAGEWIDTH).value_or(0);
  const auto rows = field<std::uint32_t>(tiff, TIFFTAG_IMAGELENGTH).value_or(0);
  check_frame_size(file, columns, rows);
  check_enough_data(file, static_cast<long long>(columns) * rows, file_bytes);
  const auto rows_per_strip =
      std::min(rows, std::max(1U, field<std::uint32_t>(tiff, TIFFTAG_ROWSPERSTRIP).value_or(rows)));
  const auto bits = short_field(tiff, TIFFTAG_BITSPERSAMPLE, 1);
  Grid<float> dn(static_cast<int>(rows), static_cast<int>(columns));
  if (bits == 8) {
    read_strips<std::uint8_t>(tiff, dn, rows_per_strip, file, message);
  } else if (bits == 16) {
    read_strips<std::uint16_t>(tiff, dn, rows_per_strip, file, message);
  } else {
    read_strips<float>(tiff, dn, rows_per_strip, file, message);
  }
  return {.dn = std::move(dn), .quantum_dn = bits == 32 ? 0.0 : 1.0, .file = path, .header = {}};
}

}  // namespace scatmap
