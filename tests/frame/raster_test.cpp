// TIFF and PNG written by libtiff and libpng, PGM written byte by byte, and read back: exact values and row order.
// libtiff and libpng stand on both sides, so their own errors would cancel; the PGM bytes are independent.
#include <cmath>
#include <cstring>

#include "frame/frame_files.h"

namespace {

using namespace frame_files;
using scatmap::Frame;
using scatmap::read_frame;

const std::vector<std::uint16_t> kCounts{0, 1, 255, 256, 32767, 32768, 43981, 65534, 65535, 7, 4660, 52};

void expect_counts(const Frame& frame) {
  ASSERT_EQ(frame.dn.columns(), 3);
  ASSERT_EQ(frame.dn.rows(), 4);
  for (std::size_t i = 0; i < kCounts.size(); ++i) EXPECT_EQ(frame.dn[i], kCounts[i]) << i;
  EXPECT_EQ(frame.dn(1, 0), 256) << "the second row stored is row 1";
  EXPECT_EQ(frame.quantum_dn, 1);
  EXPECT_FALSE(frame.header.exposure_s.has_value());
}

template <class T>
std::string as_bytes(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::string high_byte_first() {
  std::string bytes;
  for (const std::uint16_t v : kCounts) {
    bytes += static_cast<char>(v >> 8);
    bytes += static_cast<char>(v & 0xff);
  }
  return bytes;
}

std::vector<std::uint8_t> low_bytes() {
  std::vector<std::uint8_t> bytes;
  for (const std::uint16_t v : kCounts) bytes.push_back(static_cast<std::uint8_t>(v & 0xff));
  return bytes;
}

void expect_low_bytes(const Frame& frame) {
  ASSERT_EQ(frame.dn.size(), kCounts.size());
  for (std::size_t i = 0; i < kCounts.size(); ++i) EXPECT_EQ(frame.dn[i], kCounts[i] & 0xff) << i;
}

TEST(RasterTiff, Counts16InEveryByteOrderAndCompression) {
  const Path path = scratch_folder() / "a";
  for (const char* mode : {"wl", "wb", "w8"}) {
    for (const int compression :
         {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_DEFLATE, COMPRESSION_PACKBITS}) {
      for (const std::uint32_t rows_per_strip : {1U, 3U, 4U, 100U}) {
        SCOPED_TRACE(std::string(mode) + " " + std::to_string(compression) + " " + std::to_string(rows_per_strip));
        write_tiff(
            path, 3, 4, as_bytes(kCounts),
            {.compression = static_cast<std::uint16_t>(compression), .rows_per_strip = rows_per_strip, .mode = mode});
        expect_counts(read_frame(path));
      }
    }
  }
}

TEST(RasterTiff, Counts8AndFloats) {
  const Path path = scratch_folder() / "a";
  write_tiff(path, 3, 4, as_bytes(low_bytes()), {.bits = 8});
  expect_low_bytes(read_frame(path));
  const std::vector<float> values{-1.5F, 1e30F, std::nanf(""), 0.1F};
  for (const char* mode : {"wl", "wb"}) {
    write_tiff(path, 2, 2, as_bytes(values), {.bits = 32, .format = SAMPLEFORMAT_IEEEFP, .mode = mode});
    const Frame frame = read_frame(path);
    EXPECT_EQ(frame.quantum_dn, 0);
    EXPECT_EQ(frame.dn[0], -1.5F);
    EXPECT_EQ(frame.dn[1], 1e30F);
    EXPECT_TRUE(std::isnan(frame.dn[2]));
    EXPECT_EQ(frame.dn[3], 0.1F);
  }
}

TEST(RasterPng, Counts16And8PlainAndInterlaced) {
  const Path path = scratch_folder() / "a";
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
    write_png(path, 3, 4, high_byte_first(), {.bits = 16, .interlace = interlace});
    expect_counts(read_frame(path));
    write_png(path, 3, 4, as_bytes(low_bytes()), {.bits = 8, .interlace = interlace});
    expect_low_bytes(read_frame(path));
  }
}

TEST(RasterPgm, Counts16) {
  const Path path = scratch_folder() / "a";
  write_bytes(path, "P5\n3 4\n65535\n" + high_byte_first());
  expect_counts(read_frame(path));
  write_bytes(path, "P5 # 16 bit\n#more\n3#columns\n \t 4\r\n65535\t" + high_byte_first());
  expect_counts(read_frame(path));
}

TEST(RasterPgm, TheFirstPixelMayLookLikeWhiteSpaceOrAComment) {
  const Path path = scratch_folder() / "a";
  write_bytes(path, "P5 3 1 255\n\n# ");
  const Frame frame = read_frame(path);
  EXPECT_EQ(frame.dn[0], '\n');
  EXPECT_EQ(frame.dn[1], '#');
  EXPECT_EQ(frame.dn[2], ' ');
}

TEST(RasterPgm, CountsAreNotScaledByMaxval) {
  const Path path = scratch_folder() / "a";
  write_bytes(path, std::string("P5 2 1 4095\n\x0f\xff\x00\x01", 16));
  EXPECT_EQ(read_frame(path).dn[0], 4095);
  EXPECT_EQ(read_frame(path).dn[1], 1);
  write_bytes(path, "P5 2 1 100\n\x64\x05");
  EXPECT_EQ(read_frame(path).dn[0], 100);
}

TEST(RasterPgm, Text) {
  const Path path = scratch_folder() / "a";
  std::string text = "P2\n# made by hand\n3 4 65535\n";
  for (const std::uint16_t v : kCounts) text += std::to_string(v) + (v == 255 ? " # a comment\n" : " ");
  write_bytes(path, text);
  expect_counts(read_frame(path));
}

}  // namespace
