// Files that must be refused, each with the reason a user can act on, and the key tests of what is refused by header
// value. Only the stated part of each message is checked, so this does not prove that the rest reads well.
#include <sys/stat.h>

#include "frame/frame_files.h"

namespace {

using namespace frame_files;

struct Hostile {
  const char* name;
  std::string bytes;
  const char* reason;
};

const std::string kTwo("\x05\x06", 2);

// A file of one 2 x 1 image of bytes, with more cards.
std::string fits_with(const Cards& more) { return fits_header(image_cards(8, 2, 1) + more) + fits_data(kTwo); }

// The same with the text of one card replaced.
std::string fits_replacing(const std::string& from, const std::string& to) {
  std::string bytes = fits_with({});
  const std::size_t at = bytes.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return bytes.replace(at, to.size(), to);
}

std::string axes(const std::string& naxis, const Cards& more) {
  return fits_header(Cards{{"SIMPLE", "T"}, {"BITPIX", "8"}, {"NAXIS", naxis}} + more) + fits_data(kTwo);
}

void expect_refused(const std::vector<Hostile>& files) {
  const Path folder = scratch_folder();
  for (const Hostile& hostile : files) {
    const Path path = folder / "hostile";
    write_bytes(path, hostile.bytes);
    const std::string said = refusal(path);
    EXPECT_TRUE(said.starts_with(path.string() + ":")) << hostile.name << " must name the file, says: " << said;
    EXPECT_NE(said.find(hostile.reason), std::string::npos) << hostile.name << " says: " << said;
  }
}

TEST(FrameRefusal, FilesOfOtherKinds) {
  using namespace std::string_literals;
  expect_refused({
      {"empty", "", "is empty"},
      {"text", "hello, world", "is not a frame scatmap can read"},
      {"one byte", "S", "is not a frame scatmap can read"},
      {"gzip", "\x1f\x8b\x08 and so on", "is gzip-compressed; decompress it first"},
      {"compress", "\x1f\x9d\x90", "decompress it first"},
      {"bzip2", "BZh91AY", "is bzip2-compressed; decompress it first"},
      {"xz", "\xfd"s + "7zXZ\0"s, "is xz-compressed; decompress it first"},
      {"zstd", "\x28\xb5\x2f\xfd", "is zstd-compressed; decompress it first"},
      {"zip", "PK\x03\x04", "is a zip archive; unpack it first"},
      {"JPEG", "\xff\xd8\xff\xe0", "is a JPEG"},
      {"PPM", "P6 1 1 255\nabc", "is a colour image (PPM)"},
      {"PBM", "P4 8 1\nx", "one bit per pixel"},
      {"EXR", "\x76\x2f\x31\x01", "is an OpenEXR image"},
      {"PNG through a text-mode transfer", "\x89PNG\n\x1a\n", "damaged by a text-mode transfer"},
      {"FITS without its primary", fits_header(extension_cards(2, 1)) + fits_data(kTwo), "without the primary header"},
  });
}

TEST(FrameRefusal, ThingsThatAreNotFiles) {
  const Path folder = scratch_folder();
  EXPECT_NE(refusal(folder / "none.fits").find("does not exist"), std::string::npos);
  EXPECT_NE(refusal(folder).find("is a folder, not a file"), std::string::npos);
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_NE(refusal(folder / "pipe").find("is not a regular file"), std::string::npos);
  EXPECT_NE(refusal("/dev/zero").find("is not a regular file"), std::string::npos);
}

// The sum of two bytes and zeros by hand: one word, 0x05060000.
TEST(FrameRefusal, FitsDataThatAreNotAsTheyWereSummed) {
  const Path path = scratch_folder() / "frame.fits";
  const auto said = [&](const std::string& sum) {
    write_bytes(path, fits_with({{"DATASUM", sum}}));
    return refusal(path);
  };
  EXPECT_EQ(said("'84279296'"), "");
  EXPECT_EQ(said("'  84279296'"), "");  // as CFITSIO fills it
  EXPECT_EQ(said("'        '"), "");    // not known
  EXPECT_NE(said("'84279297'").find("(DATASUM): is not the sum of the data"), std::string::npos) << said("'84279297'");
  EXPECT_NE(said("'many'").find("(DATASUM): is not the sum of the data"), std::string::npos);
}

TEST(FrameRefusal, FitsStructure) {
  const std::string good = fits_with({});
  ASSERT_EQ(good.size(), 5760U);
  std::string endless = good;
  endless.replace(endless.find("END "), 3, "   ");
  std::string end_text = good;
  end_text[end_text.find("END ") + 20] = 'x';
  expect_refused({
      {"SIMPLE = F", fits_replacing("                   T", "                   F"), "does not conform to FITS"},
      {"SIMPLE = 1", fits_replacing("                   T", "                   1"), "(SIMPLE): is not a logical"},
      {"header only", good.substr(0, 2880), "HDU 1: is truncated"},
      {"half a header", good.substr(0, 1000), "before the END card"},
      {"no END", endless, "before the END card"},
      {"END followed by text", end_text, "END card that is not blank"},
      {"endless header", good.substr(0, 400) + std::string(3'000'000, ' '), "too long a header"},
      {"BITPIX = 12", fits_replacing("                   8", "                  12"), "is not a pixel type"},
      {"BITPIX = 64", fits_replacing("                   8", "                  64"), "is not a pixel type"},
      {"BITPIX = 8.5", fits_replacing("                   8", "                 8.5"), "(BITPIX): is not an integer"},
      {"BITPIX = '8'", fits_replacing("                   8", "'8       '          "), "(BITPIX): is not an integer"},
      {"no BITPIX", fits_replacing("BITPIX", "BATPIX"), "card 2: is not the keyword that must stand here"},
      {"NAXIS without =", fits_replacing("NAXIS   = ", "NAXIS     "), "(NAXIS): "},
      {"NAXIS = 999", axes("999", {}), "(NAXIS): is out of range"},
      {"NAXIS = -1", axes("-1", {}), "(NAXIS): is out of range"},
      {"NAXIS = 0", axes("0", {}), "holds no image"},
      {"NAXIS1 only", axes("2", {{"NAXIS1", "2"}}), "card 5: is missing"},
      {"axes swapped", axes("2", {{"NAXIS2", "1"}, {"NAXIS1", "2"}}), "card 4: is not the keyword"},
      {"one axis", axes("1", {{"NAXIS1", "2"}}), "holds a row of values"},
      {"an axis too many", fits_with({{"NAXIS3", "1"}}), "(NAXIS3): contradicts NAXIS"},
      {"NAXIS01", fits_with({{"NAXIS01", "2"}}), "(NAXIS01): contradicts NAXIS"},
      {"four axes", axes("4", {{"NAXIS1", "2"}, {"NAXIS2", "1"}, {"NAXIS3", "1"}, {"NAXIS4", "1"}}), "too many axes"},
      {"a cube", axes("3", {{"NAXIS1", "1"}, {"NAXIS2", "1"}, {"NAXIS3", "2"}}), "is a cube of several images, got 2"},
      {"negative axis", axes("2", {{"NAXIS1", "-2"}, {"NAXIS2", "-1"}}), "(NAXIS1): is out of range"},
      {"zero axis", axes("2", {{"NAXIS1", "0"}, {"NAXIS2", "1"}}), "holds no image"},
      {"huge axis", axes("2", {{"NAXIS1", "9223372036854775807"}, {"NAXIS2", "2"}}), "(NAXIS1): is out of range"},
      {"axis beyond 64 bit", axes("2", {{"NAXIS1", "99999999999999999999"}, {"NAXIS2", "2"}}), "is not an integer"},
      {"product beyond 64 bit",
       axes("8", {{"NAXIS1", "2147483647"},
                  {"NAXIS2", "2147483647"},
                  {"NAXIS3", "2147483647"},
                  {"NAXIS4", "2147483647"},
                  {"NAXIS5", "2147483647"},
                  {"NAXIS6", "2147483647"},
                  {"NAXIS7", "2147483647"},
                  {"NAXIS8", "2147483647"}}),
       "more data than the file has"},
      {"more pixels than bytes", axes("2", {{"NAXIS1", "32768"}, {"NAXIS2", "32768"}}), "more data than the file has"},
      {"data not filled to a block", good.substr(0, good.size() - 1), "is truncated"},
      {"BITPIX twice", fits_with({{"BITPIX", "8"}}), "card 6 (BITPIX): stands twice"},
      {"NAXIS1 twice", fits_with({{"NAXIS1", "1"}}), "(NAXIS1): stands twice"},
      {"BZERO twice", fits_with({{"BZERO", "0"}, {"BZERO", "32768"}}), "(BZERO): stands twice"},
      {"SIMPLE late", fits_with({{"XTENSION", "'IMAGE'"}}), "in the middle of a header"},
      {"PCOUNT in a primary image", fits_with({{"PCOUNT", "100"}}), "(PCOUNT): is out of range"},
      {"GCOUNT in a primary image", fits_with({{"GCOUNT", "0"}}), "(GCOUNT): is out of range"},
      {"random groups", axes("2", {{"NAXIS1", "0"}, {"NAXIS2", "1"}, {"GROUPS", "T"}}), "random groups"},
      {"tile-compressed",
       fits_header(empty_primary()) +
           fits_header({{"XTENSION", "'BINTABLE'"},
                        {"BITPIX", "8"},
                        {"NAXIS", "2"},
                        {"NAXIS1", "1"},
                        {"NAXIS2", "2"},
                        {"PCOUNT", "0"},
                        {"GCOUNT", "1"},
                        {"TFIELDS", "1"},
                        {"TFORM1", "'1B'"},
                        {"ZIMAGE", "T"}}) +
           fits_data(kTwo),
       "run funpack on the file first"},
      {"huge heap",
       fits_header(empty_primary()) + fits_header({{"XTENSION", "'BINTABLE'"},
                                                   {"BITPIX", "8"},
                                                   {"NAXIS", "2"},
                                                   {"NAXIS1", "1"},
                                                   {"NAXIS2", "2"},
                                                   {"PCOUNT", "2147483647"},
                                                   {"GCOUNT", "2147483647"}}),
       "more data than the file has"},
      // CFITSIO reserved 320 GB for these columns (found by fuzzing).
      {"table of too many columns",
       fits_header(empty_primary()) +
           fits_header({{"XTENSION", "'BINTABLE'"},
                        {"BITPIX", "8"},
                        {"NAXIS", "2"},
                        {"NAXIS1", "2"},
                        {"NAXIS2", "1"},
                        {"PCOUNT", "0"},
                        {"GCOUNT", "1"},
                        {"TFIELDS", "2147483648"}}) +
           fits_data(kTwo),
       "(TFIELDS): is out of range, got 2147483648, expected 0 to 999"},
      // CFITSIO counts cards, took another one for TFIELDS and asked for petabytes (found by fuzzing).
      {"table whose TFIELDS is not the eighth card",
       fits_header(empty_primary()) +
           fits_header({{"XTENSION", "'BINTABLE'"},
                        {"BITPIX", "8"},
                        {"NAXIS", "2"},
                        {"NAXIS1", "2"},
                        {"NAXIS2", "1"},
                        {"PCOUNT", "0"},
                        {"GCOUNT", "1"},
                        {"OTHER", "2147483648"},
                        {"TFIELDS", "1"}}) +
           fits_data(kTwo),
       "HDU 2, card 8: is not the keyword that must stand here, got OTHER, expected TFIELDS"},
      {"table of one axis",
       fits_header(empty_primary()) +
           fits_header({{"XTENSION", "'BINTABLE'"},
                        {"BITPIX", "8"},
                        {"NAXIS", "1"},
                        {"NAXIS1", "2"},
                        {"PCOUNT", "0"},
                        {"GCOUNT", "1"},
                        {"TFIELDS", "1"}}) +
           fits_data(kTwo),
       "(NAXIS): is out of range, got 1, expected 2 to 2"},
      {"extension without PCOUNT",
       fits_header(empty_primary()) +
           fits_header({{"XTENSION", "'IMAGE'"}, {"BITPIX", "8"}, {"NAXIS", "2"}, {"NAXIS1", "2"}, {"NAXIS2", "1"}}) +
           fits_data(kTwo),
       "HDU 2: has no PCOUNT"},
      {"extension cut in its header", good + fits_header(extension_cards(2, 1)).substr(0, 900), "HDU 2: is truncated"},
      {"two image extensions",
       fits_header(empty_primary()) + fits_header(extension_cards(2, 1, {{"EXTNAME", "'LEFT'"}})) + fits_data(kTwo) +
           fits_header(extension_cards(2, 1)) + fits_data(kTwo),
       "holds several images, got 2 (LEFT, HDU 3)"},
  });
}

TEST(FrameRefusal, FitsValues) {
  expect_refused({
      {"EXPTIME text", fits_with({{"EXPTIME", "'2.5'"}}), "(EXPTIME): is not a number, got '2.5'"},
      {"EXPTIME NaN", fits_with({{"EXPTIME", "NaN"}}), "(EXPTIME): is not a number"},
      {"EXPTIME inf", fits_with({{"EXPTIME", "inf"}}), "(EXPTIME): is not a number"},
      {"EXPTIME overflow", fits_with({{"EXPTIME", "1E999"}}), "(EXPTIME): is not a number"},
      {"EXPTIME negative", fits_with({{"EXPTIME", "-0.5"}}), "(EXPTIME): is out of range, got -0.5, expected >= 0"},
      {"EXPTIME undefined", fits_with({{"EXPTIME", ""}}), "(EXPTIME): is not a number, got no value"},
      {"EXPTIME with unit", fits_with({{"EXPTIME", "2.5 s"}}), "(EXPTIME): is not a number"},
      {"EXPTIME twice", fits_with({{"EXPTIME", "1"}, {"EXPTIME", "2"}}), "(EXPTIME): stands twice with different"},
      {"EXPOSURE negative", fits_with({{"EXPOSURE", "-1"}}), "(EXPOSURE): is out of range"},
      {"EGAIN zero", fits_with({{"EGAIN", "0"}}), "(EGAIN): is out of range"},
      {"SATURATE text", fits_with({{"SATURATE", "'full'"}}), "(SATURATE): is not a number"},
      {"STAGEDEG text", fits_with({{"STAGEDEG", "T"}}), "(STAGEDEG): is not a number"},
      {"ROWORDER unknown", fits_with({{"ROWORDER", "'SIDEWAYS'"}}), "(ROWORDER): is not a row order, got SIDEWAYS"},
      {"ROWORDER unclosed", fits_with({{"ROWORDER", "'TOP-DOWN"}}), "(ROWORDER): is not a string"},
      {"DATE-OBS number", fits_with({{"DATE-OBS", "2021"}}), "(DATE-OBS): is not a string"},
      {"BSCALE zero", fits_with({{"BSCALE", "0"}}), "(BSCALE): makes every pixel equal"},
      {"BSCALE NaN", fits_with({{"BSCALE", "nan"}}), "(BSCALE): is not a number"},
      {"BZERO text", fits_with({{"BZERO", "'0'"}}), "(BZERO): is not a number"},
      {"BZERO beyond a float's integers", fits_with({{"BZERO", "16777216"}}), "is beyond 2^24"},
      {"BLANK not an integer", fits_with({{"BLANK", "1.5"}}), "(BLANK): is not an integer"},
  });
}

TEST(FrameRefusal, Tiff) {
  struct Case {
    const char* name;
    TiffOptions options;
    const char* reason;
  };
  const std::vector<Case> cases{
      {"colour", {.bits = 8, .photometric = PHOTOMETRIC_RGB, .samples = 3}, "is a colour image"},
      {"palette", {.bits = 8, .photometric = PHOTOMETRIC_PALETTE}, "has a colour palette"},
      {"min-is-white", {.photometric = PHOTOMETRIC_MINISWHITE}, "min-is-white"},
      {"grey and alpha", {.samples = 2}, "several samples per pixel, got 2"},
      {"signed", {.format = SAMPLEFORMAT_INT}, "got 16 bit signed"},
      {"12 bit", {.bits = 12}, "got 12 bit unsigned"},
      {"1 bit", {.bits = 1}, "got 1 bit unsigned"},
      {"32 bit integer", {.bits = 32}, "got 32 bit unsigned"},
      {"double", {.bits = 64, .format = SAMPLEFORMAT_IEEEFP}, "got 64 bit floating-point"},
      {"half", {.bits = 16, .format = SAMPLEFORMAT_IEEEFP}, "got 16 bit floating-point"},
      {"flipped", {.orientation = ORIENTATION_BOTLEFT}, "a flip changes the sign of phi, got Orientation 4"},
      {"two pages", {.pages = 2}, "holds several pages, got 2"},
      {"tiles", {.tile = 16}, "is stored in tiles"},
      {"JPEG", {.bits = 8, .compression = COMPRESSION_JPEG, .rows_per_strip = 16}, "is JPEG-compressed: lossy"},
      {"LZMA", {.compression = COMPRESSION_LZMA}, "has a compression scatmap does not read"},
  };
  const Path path = scratch_folder() / "a.tif";
  for (const Case& c : cases) {
    write_tiff(path, 16, 16, std::string(16 * 16 * 8, '\1'), c.options);
    const std::string said = refusal(path);
    EXPECT_NE(said.find(c.reason), std::string::npos) << c.name << " says: " << said;
  }
}

// An IFD of four entries: too small for what it announces.
TEST(FrameRefusal, TiffThatAsksForMoreThanItHolds) {
  using namespace std::string_literals;
  const auto entry = [](int tag, std::uint32_t value) {
    std::string bytes{static_cast<char>(tag & 0xff), static_cast<char>(tag >> 8), 4, 0, 1, 0, 0, 0};
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i));
    return bytes;
  };
  const auto tiff = [&](std::uint32_t columns, std::uint32_t rows) {
    return "II*\0\x08\0\0\0\x09\0"s + entry(256, columns) + entry(257, rows) + entry(258, 16) + entry(259, 1) +
           entry(262, 1) + entry(273, 8) + entry(277, 1) + entry(278, rows) + entry(279, 16) + "\0\0\0\0"s;
  };
  expect_refused({
      {"4 Gi x 4 Gi", tiff(0xffffffffU, 0xffffffffU), "TIFF"},
      {"2^15 x 2^16", tiff(32768, 65536), "holds more pixels than a frame may have"},
      {"2^30 pixels", tiff(32768, 32768), "is too short for the pixels it announces"},
      {"strip beyond the end", tiff(100, 100), "is truncated or damaged in strip 0"},
      {"no columns", tiff(0, 5), "TIFF"},
      {"directory beyond the end", "II*\0\xff\xff\0\0"s, "is truncated or not a valid TIFF"},
      {"directory of itself", "II*\0\0\0\0\0"s, "is truncated or not a valid TIFF"},
  });
}

TEST(FrameRefusal, Png) {
  struct Case {
    const char* name;
    PngOptions options;
    const char* reason;
  };
  const std::vector<Case> cases{
      {"colour", {.bits = 8, .color = PNG_COLOR_TYPE_RGB}, "is a colour image"},
      {"palette", {.bits = 8, .color = PNG_COLOR_TYPE_PALETTE}, "has a colour palette"},
      {"alpha", {.bits = 8, .color = PNG_COLOR_TYPE_GRAY_ALPHA}, "has transparency"},
      {"transparent value", {.bits = 16, .transparent_value = true}, "has transparency"},
      {"4 bit", {.bits = 4}, "has too few bits, got 4 bit"},
  };
  const Path path = scratch_folder() / "a.png";
  for (const Case& c : cases) {
    write_png(path, 4, 2, std::string(4 * 2 * 4, '\0'), c.options);
    const std::string said = refusal(path);
    EXPECT_NE(said.find(c.reason), std::string::npos) << c.name << " says: " << said;
  }
}

TEST(FrameRefusal, PngThatLies) {
  const Path path = scratch_folder() / "a.png";
  write_png(path, 4, 2, std::string(16, '\3'), {});
  std::string bytes = read_bytes(path);
  bytes[19] = 5;  // the width, against its checksum
  write_bytes(path, bytes);
  EXPECT_NE(refusal(path).find("libpng says 'IHDR: CRC error'"), std::string::npos) << refusal(path);
  write_png(path, 4, 2, std::string(16, '\3'), {});
  bytes = read_bytes(path);
  bytes.replace(bytes.find("IDAT") + 8, 1, "\x55");
  write_bytes(path, bytes);
  EXPECT_NE(refusal(path).find("is truncated or damaged: libpng says"), std::string::npos) << refusal(path);
}

TEST(FrameRefusal, Pgm) {
  using namespace std::string_literals;
  expect_refused({
      {"no white space", "P5x2 1 255\nab", "white space must follow"},
      {"only magic", "P5", "is truncated"},
      {"no maxval", "P5 2 1 ", "is truncated in its maxval"},
      {"negative width", "P5 -2 1 255\nab", "has a width that is not a whole number"},
      {"fractional height", "P5 2 1.5 255\nab", "has a height that is not a whole number"},
      {"huge width", "P5 99999999999999999999 1 255\nab", "has a width out of range"},
      {"too many pixels", "P5 1073741824 2 255\nab", "more pixels than a frame may have"},
      {"no pixels", "P5 0 1 255\n", "image without pixels"},
      {"maxval 0", "P5 2 1 0\nab", "has a maxval out of range, got 0"},
      {"maxval 65536", "P5 2 1 65536\nabcd", "has a maxval out of range, got 65536"},
      {"truncated", "P5 2 2 255\nabc", "is truncated, got 3 bytes of pixels, expected 4"},
      {"truncated 16 bit", "P5 2 2 65535\nabcdefg", "is truncated, got 7 bytes of pixels, expected 8"},
      {"two images", "P5 2 1 255\nabP5 2 1 255\ncd", "several images in one file"},
      {"CR LF after maxval", "P5 2 1 255\r\nab", "got 3 bytes of pixels, expected 2"},
      {"above maxval", "P5 2 1 100\n\x05\x65"s,
       "pixel (column 1, row 0): is above maxval, got 101, expected at most 100"},
      {"above maxval, 16 bit", "P5 1 2 4095\n\x0f\xff\x10\x00"s, "pixel (column 0, row 1): is above maxval, got 4096"},
      {"text truncated", "P2 2 2 255\n1 2 333 ", "is truncated"},
      {"text above maxval", "P2 2 1 255\n1 256\n", "is above maxval, got 256"},
      {"text with a letter", "P2 2 1 255\n1 2a3\n", "that is not a whole number"},
      {"text negative", "P2 2 1 255\n1 -2\n", "that is not a whole number"},
      {"text, two images", "P2 2 1 255\n1 2\nP2 2 1 255\n3 4\n", "several images in one file"},
      {"text, huge", "P2 30000 30000 255\n1 2 3\n", "is truncated"},
  });
}

}  // namespace
