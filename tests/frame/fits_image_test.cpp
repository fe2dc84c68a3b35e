// FITS images written by CFITSIO or byte by byte, and read back: exact values, row order, scaling, BLANK, header keys,
// which HDU is taken, and file names. Does not prove that damaged files are refused: refusal_test, damage_test.
#include <fitsio.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "frame/frame_files.h"

namespace {

using namespace frame_files;
using scatmap::Frame;
using scatmap::read_frame;

template <class T>
void write_with_cfitsio(const Path& path, int image_type, int data_type, long columns, long rows,
                        std::vector<T> values) {
  fitsfile* file = nullptr;
  int status = 0;
  std::array<long, 2> axes{columns, rows};
  fits_create_diskfile(&file, path.c_str(), &status);
  fits_create_img(file, image_type, 2, axes.data(), &status);
  fits_write_img(file, data_type, 1, static_cast<LONGLONG>(values.size()), values.data(), &status);
  fits_close_file(file, &status);
  ASSERT_EQ(status, 0);
}

void expect_row_after_row(const Frame& frame, int columns, int rows, const std::vector<float>& expected) {
  ASSERT_EQ(frame.dn.columns(), columns);
  ASSERT_EQ(frame.dn.rows(), rows);
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(frame.dn[i], expected[i]) << "pixel " << i;
}

TEST(FitsImage, Unsigned16) {
  const Path path = scratch_folder() / "a.fits";
  write_with_cfitsio<std::uint16_t>(path, USHORT_IMG, TUSHORT, 3, 2, {0, 1, 32767, 32768, 65534, 65535});
  const Frame frame = read_frame(path);
  expect_row_after_row(frame, 3, 2, {0, 1, 32767, 32768, 65534, 65535});
  EXPECT_EQ(frame.dn(1, 0), 32768) << "the second row stored is row 1";
  EXPECT_EQ(frame.quantum_dn, 1);
  EXPECT_EQ(frame.file, path);
}

TEST(FitsImage, EveryPixelOfALargeFrame) {
  const Path path = scratch_folder() / "a.fits";
  std::vector<std::uint16_t> values(700 * 300);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint16_t>(i * 40503u);
  write_with_cfitsio(path, USHORT_IMG, TUSHORT, 700, 300, values);
  expect_row_after_row(read_frame(path), 700, 300, std::vector<float>(values.begin(), values.end()));
}

TEST(FitsImage, OtherIntegers) {
  const Path folder = scratch_folder();
  write_with_cfitsio<std::uint8_t>(folder / "8", BYTE_IMG, TBYTE, 2, 2, {0, 1, 128, 255});
  expect_row_after_row(read_frame(folder / "8"), 2, 2, {0, 1, 128, 255});
  write_with_cfitsio<short>(folder / "16", SHORT_IMG, TSHORT, 2, 2, {-32768, -1, 0, 32767});
  expect_row_after_row(read_frame(folder / "16"), 2, 2, {-32768, -1, 0, 32767});
  write_with_cfitsio<int>(folder / "32", LONG_IMG, TINT, 2, 2, {-16777216, -1, 16777215, 16777216});
  expect_row_after_row(read_frame(folder / "32"), 2, 2, {-16777216, -1, 16777215, 16777216});
  write_with_cfitsio<unsigned>(folder / "u32", ULONG_IMG, TUINT, 2, 2, {0, 1, 65536, 16777216});
  expect_row_after_row(read_frame(folder / "u32"), 2, 2, {0, 1, 65536, 16777216});
}

TEST(FitsImage, FloatingPoint) {
  const Path folder = scratch_folder();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const float tiny = 1e-42F;  // subnormal: CFITSIO's null check would set it to 0
  write_with_cfitsio<float>(folder / "32", FLOAT_IMG, TFLOAT, 3, 2, {-1.5F, nan, 3e38F, inf, tiny, 0.1F});
  const Frame single = read_frame(folder / "32");
  EXPECT_EQ(single.quantum_dn, 0);
  EXPECT_TRUE(std::isnan(single.dn[1]));
  for (const auto& [i, expected] : {std::pair{0, -1.5F}, {2, 3e38F}, {3, inf}, {4, tiny}, {5, 0.1F}}) {
    EXPECT_EQ(single.dn[static_cast<std::size_t>(i)], expected) << i;
  }
  write_with_cfitsio<double>(folder / "64", DOUBLE_IMG, TDOUBLE, 2, 2, {0.1, nan, -65535.0, inf});
  const Frame wide = read_frame(folder / "64");
  EXPECT_EQ(wide.quantum_dn, 0);
  EXPECT_EQ(wide.dn[0], 0.1F);
  EXPECT_TRUE(std::isnan(wide.dn[1]));
  EXPECT_EQ(wide.dn[2], -65535.0F);
  EXPECT_EQ(wide.dn[3], inf);
}

TEST(FitsImage, ValuesThatAFloatWouldRoundAreRefusedWithTheirPosition) {
  const Path folder = scratch_folder();
  write_with_cfitsio<int>(folder / "32", LONG_IMG, TINT, 3, 2, {0, 0, 0, 0, 16777217, 0});
  EXPECT_NE(refusal(folder / "32").find("pixel (column 1, row 1): is beyond 2^24"), std::string::npos);
  EXPECT_NE(refusal(folder / "32").find("16777217"), std::string::npos);
  write_with_cfitsio<int>(folder / "-32", LONG_IMG, TINT, 1, 3, {0, 0, -16777217});
  EXPECT_NE(refusal(folder / "-32").find("pixel (column 0, row 2): is beyond 2^24"), std::string::npos);
  write_with_cfitsio<double>(folder / "64", DOUBLE_IMG, TDOUBLE, 2, 1, {0, 1e300});
  EXPECT_NE(refusal(folder / "64").find("pixel (column 1, row 0): is too large for a float"), std::string::npos);
}

TEST(FitsImage, ZeroScaleAndBlank) {
  const Path folder = scratch_folder();
  const std::string pixels("\x00\x00\x00\x64\xff\xff\x80\x00", 8);  // 0, 100, -1, -32768
  write_bytes(folder / "s", fits_header(image_cards(16, 2, 2) +
                                        Cards{{"BZERO", "1000.5"}, {"BSCALE", "-2.5D-1"}, {"BLANK", "-32768"}}) +
                                fits_data(pixels));
  const Frame frame = read_frame(folder / "s");
  EXPECT_EQ(frame.dn[0], 1000.5F);
  EXPECT_EQ(frame.dn[1], 975.5F);
  EXPECT_EQ(frame.dn[2], 1000.75F);
  EXPECT_TRUE(std::isnan(frame.dn[3]));
  EXPECT_EQ(frame.quantum_dn, 0.25);

  write_bytes(folder / "b8", fits_header(image_cards(8, 2, 1) + Cards{{"BLANK", "255"}}) + fits_data("\x07\xff"));
  EXPECT_EQ(read_frame(folder / "b8").dn[0], 7);
  EXPECT_TRUE(std::isnan(read_frame(folder / "b8").dn[1]));

  const std::string wide("\x00\x00\x00\x05\x7f\xff\xff\xff", 8);  // BLANK beyond 2^24 is still only a blank
  write_bytes(folder / "b32", fits_header(image_cards(32, 2, 1) + Cards{{"BLANK", "2147483647"}}) + fits_data(wide));
  EXPECT_EQ(read_frame(folder / "b32").dn[0], 5);
  EXPECT_TRUE(std::isnan(read_frame(folder / "b32").dn[1]));
}

TEST(FitsImage, ScaledFloats) {
  const Path path = scratch_folder() / "f";
  const std::string pixels("\x3f\x80\x00\x00\x7f\xc0\x00\x00", 8);  // 1, NaN
  write_bytes(path, fits_header(image_cards(-32, 2, 1) + Cards{{"BZERO", "10"}, {"BSCALE", "4"}}) + fits_data(pixels));
  EXPECT_EQ(read_frame(path).dn[0], 14);
  EXPECT_TRUE(std::isnan(read_frame(path).dn[1]));
  EXPECT_EQ(read_frame(path).quantum_dn, 0);
}

TEST(FitsImage, HeaderKeys) {
  const Path folder = scratch_folder();
  write_bytes(folder / "all", fits_header(image_cards(8, 1, 1) + Cards{{"EXPOSURE", "7"},
                                                                       {"EXPTIME", "2.5E-3 / seconds"},
                                                                       {"GAIN", "120"},
                                                                       {"EGAIN", "0.75"},
                                                                       {"SATURATE", "65535"},
                                                                       {"STAGEDEG", "-20.25"},
                                                                       {"ARMDEG", "+40."},
                                                                       {"ROWORDER", "'BOTTOM-UP' / Siril"},
                                                                       {"DATE-OBS", "'2021-10-01T12:00:00  '"}}) +
                                  fits_data("x"));
  const auto h = read_frame(folder / "all").header;
  EXPECT_EQ(h.exposure_s, 2.5e-3);
  EXPECT_EQ(h.gain_e_per_dn, 0.75);
  EXPECT_EQ(h.saturation_dn, 65535);
  EXPECT_EQ(h.stage_deg, -20.25);
  EXPECT_EQ(h.arm_deg, 40);
  EXPECT_EQ(h.row_order, "BOTTOM-UP");
  EXPECT_EQ(h.date, "2021-10-01T12:00:00");

  write_bytes(folder / "some",
              fits_header(image_cards(8, 1, 1) + Cards{{"EXPOSURE", "0"}, {"GAIN", "2"}}) + fits_data("x"));
  const auto s = read_frame(folder / "some").header;
  EXPECT_EQ(s.exposure_s, 0);
  EXPECT_FALSE(s.gain_e_per_dn || s.saturation_dn || s.stage_deg || s.arm_deg || s.row_order || s.date);
}

TEST(FitsImage, OneExtensionTakesWhatItsPrimaryHeaderSays) {
  const Path folder = scratch_folder();
  const std::string primary = fits_header(empty_primary({{"EXPTIME", "3"}, {"ARMDEG", "40"}}));
  write_bytes(folder / "a", primary + fits_header(extension_cards(2, 1, {{"EXPTIME", "4"}})) + fits_data("\x05\x06"));
  EXPECT_EQ(read_frame(folder / "a").dn[1], 6);
  EXPECT_EQ(read_frame(folder / "a").header.exposure_s, 4);
  EXPECT_EQ(read_frame(folder / "a").header.arm_deg, 40);
  write_bytes(folder / "b", primary + fits_header(extension_cards(2, 1, {{"INHERIT", "F"}})) + fits_data("\x05\x06"));
  EXPECT_FALSE(read_frame(folder / "b").header.exposure_s.has_value());
}

TEST(FitsImage, ATableBeforeTheImageIsSkipped) {
  const Path path = scratch_folder() / "a";
  const Cards table{{"XTENSION", "'BINTABLE'"},
                    {"BITPIX", "8"},
                    {"NAXIS", "2"},
                    {"NAXIS1", "4"},
                    {"NAXIS2", "2"},
                    {"PCOUNT", "0"},
                    {"GCOUNT", "1"},
                    {"TFIELDS", "1"},
                    {"TFORM1", "'1J'"}};
  write_bytes(path, fits_header(empty_primary()) + fits_header(table) + fits_data("12345678") +
                        fits_header(extension_cards(2, 1)) + fits_data("\x05\x06"));
  EXPECT_EQ(read_frame(path).dn[0], 5);
}

TEST(FitsImage, PrimaryImageWinsOverItsExtensions) {
  const Path path = scratch_folder() / "a";
  write_bytes(path, fits_header(image_cards(8, 2, 1)) + fits_data("\x01\x02") + fits_header(extension_cards(2, 1)) +
                        fits_data("\x05\x06"));
  EXPECT_EQ(read_frame(path).dn[0], 1);
}

TEST(FitsImage, OnePlaneCubeAndTrailingBytes) {
  const Path path = scratch_folder() / "a";
  write_bytes(
      path, fits_header(
                {{"SIMPLE", "T"}, {"BITPIX", "8"}, {"NAXIS", "3"}, {"NAXIS1", "2"}, {"NAXIS2", "1"}, {"NAXIS3", "1"}}) +
                fits_data("\x05\x06") + "left by the camera's driver");
  expect_row_after_row(read_frame(path), 2, 1, {5, 6});
}

// CFITSIO's extended syntax would take these names apart, and would write the file named in parentheses.
TEST(FitsImage, NamesAreOnlyNames) {
  const Path folder = scratch_folder();
  const std::string bytes = fits_header(image_cards(8, 2, 1)) + fits_data("\x05\x06");
  const std::vector<std::string> names{
      "a[1].fits",  "b(c.fits).fits", "-dash.fits",     "sp ace \u00fc.fits", " lead.fits",
      "~home.fits", "a.fits[0][1:1]", "x.fits(y.fits)", "mem:.fits",          "-",
      "stdin",      "tail.fits ",     "p.fits+1"};
  for (const auto& name : names) write_bytes(folder / name, bytes);
  for (const auto& name : names) EXPECT_EQ(refusal(folder / name), "") << name;
  const Path before = std::filesystem::current_path();
  std::filesystem::current_path(folder);
  for (const auto& name : names) EXPECT_EQ(refusal(name), "") << "as relative path: " << name;
  std::filesystem::current_path(before);
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    ++files;
    EXPECT_EQ(read_bytes(entry.path()), bytes) << entry.path();
  }
  EXPECT_EQ(files, names.size()) << "something else was written";
}

}  // namespace
