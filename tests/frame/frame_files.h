#pragma once
// Small frame files for the tests of this room, made without scatmap's own code.
#include <gtest/gtest.h>
#include <png.h>
#include <tiffio.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/frame/frame.h"

namespace frame_files {

using Path = std::filesystem::path;

/// An empty folder of the running test's own.
inline Path scratch_folder() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const Path folder = Path(testing::TempDir()) / (std::string("frame_") + info->test_suite_name() + "_" + info->name());
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

inline void write_bytes(const Path& path, const std::string& bytes) {
  std::filesystem::remove(path);  // some file systems flush to disk when a file is overwritten, milliseconds each time
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

inline std::string read_bytes(const Path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What read_frame says of a file it refuses; empty when it reads it.
inline std::string refusal(const Path& path) {
  try {
    scatmap::read_frame(path);
  } catch (const scatmap::Error& error) {
    return error.what();
  }
  return "";
}

// ---- FITS, byte by byte

inline std::string filled(std::string text, std::size_t block, char fill) {
  text.resize((text.size() + block - 1) / block * block, fill);
  return text;
}

/// One card: "NAXIS1", "12" gives "NAXIS1  =                   12".
inline std::string card(const std::string& key, const std::string& value) {
  std::string text = filled(key, 8, ' ') + "= ";
  if (value.size() < 20 && !value.starts_with('\'')) text += std::string(20 - value.size(), ' ');
  return filled(text + value, 80, ' ');
}

using Cards = std::vector<std::pair<std::string, std::string>>;

inline std::string fits_header(const Cards& cards) {
  std::string text;
  for (const auto& [key, value] : cards) text += card(key, value);
  return filled(text + filled("END", 80, ' '), 2880, ' ');
}

inline Cards image_cards(int bitpix, int columns, int rows) {
  return {{"SIMPLE", "T"},
          {"BITPIX", std::to_string(bitpix)},
          {"NAXIS", "2"},
          {"NAXIS1", std::to_string(columns)},
          {"NAXIS2", std::to_string(rows)}};
}

inline Cards operator+(Cards left, const Cards& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

inline std::string fits_data(std::string bytes) { return filled(std::move(bytes), 2880, '\0'); }

/// Header of an IMAGE extension of one byte per pixel.
inline Cards extension_cards(int columns, int rows, const Cards& more = {}) {
  return Cards{{"XTENSION", "'IMAGE   '"},       {"BITPIX", "8"}, {"NAXIS", "2"}, {"NAXIS1", std::to_string(columns)},
               {"NAXIS2", std::to_string(rows)}, {"PCOUNT", "0"}, {"GCOUNT", "1"}} +
         more;
}

inline Cards empty_primary(const Cards& more = {}) {
  return Cards{{"SIMPLE", "T"}, {"BITPIX", "8"}, {"NAXIS", "0"}} + more;
}

// ---- TIFF through libtiff

struct TiffOptions {
  std::uint16_t bits = 16;
  std::uint16_t format = SAMPLEFORMAT_UINT;
  std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
  std::uint16_t samples = 1;
  std::uint16_t orientation = ORIENTATION_TOPLEFT;
  std::uint16_t compression = COMPRESSION_NONE;
  std::uint32_t rows_per_strip = 2;
  std::uint32_t tile = 0;  ///< side of the tiles; 0 stores strips
  int pages = 1;
  const char* mode = "w";
};

/// `bytes`: the samples of the image in this machine's byte order, row after row.
inline void write_tiff(const Path& path, std::uint32_t columns, std::uint32_t rows, const std::string& bytes,
                       const TiffOptions& o) {
  TIFFSetWarningHandler(nullptr);  // libtiff calls one of the two Deflate codes old
  TIFF* tiff = TIFFOpen(path.c_str(), o.mode);
  ASSERT_NE(tiff, nullptr);
  for (int page = 0; page < o.pages; ++page) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, columns);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, rows);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, o.bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, o.format);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, o.samples);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, o.photometric);
    TIFFSetField(tiff, TIFFTAG_ORIENTATION, o.orientation);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, o.compression);
    if (o.photometric == PHOTOMETRIC_PALETTE) {
      std::vector<std::uint16_t> map(std::size_t{1} << o.bits, 7);
      TIFFSetField(tiff, TIFFTAG_COLORMAP, map.data(), map.data(), map.data());
    }
    if (o.tile > 0) {
      TIFFSetField(tiff, TIFFTAG_TILEWIDTH, o.tile);
      TIFFSetField(tiff, TIFFTAG_TILELENGTH, o.tile);
      std::string tile(static_cast<std::size_t>(TIFFTileSize(tiff)), '\1');
      TIFFWriteEncodedTile(tiff, 0, tile.data(), TIFFTileSize(tiff));
    } else {
      TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, o.rows_per_strip);
      std::string copy = bytes;
      for (std::uint32_t r = 0; r < rows; ++r) {
        TIFFWriteScanline(tiff, copy.data() + static_cast<std::ptrdiff_t>(r * (copy.size() / rows)), r, 0);
      }
    }
    TIFFWriteDirectory(tiff);
  }
  TIFFClose(tiff);
}

// ---- PNG through libpng

struct PngOptions {
  int bits = 16;
  int color = PNG_COLOR_TYPE_GRAY;
  int interlace = PNG_INTERLACE_NONE;
  bool transparent_value = false;
};

/// `bytes`: the rows as PNG stores them (16 bit: high byte first).
inline void write_png(const Path& path, std::uint32_t columns, std::uint32_t rows, std::string bytes,
                      const PngOptions& o) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  ASSERT_NE(file, nullptr);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, columns, rows, o.bits, o.color, o.interlace, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (o.color == PNG_COLOR_TYPE_PALETTE) {
    const std::vector<png_color> palette(256, png_color{1, 2, 3});
    png_set_PLTE(png, info, palette.data(), 1 << o.bits);
  }
  const png_color_16 key{0, 0, 0, 0, 5};
  if (o.transparent_value) png_set_tRNS(png, info, nullptr, 0, &key);
  png_write_info(png, info);
  std::vector<png_bytep> lines;
  for (std::uint32_t r = 0; r < rows; ++r) {
    lines.push_back(reinterpret_cast<png_bytep>(bytes.data()) + r * (bytes.size() / rows));
  }
  png_write_image(png, lines.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

}  // namespace frame_files
