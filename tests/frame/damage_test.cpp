// Every prefix of a small file of each format must be refused, and no single damaged byte may crash a reader. Run it
// under -fsanitize=address,undefined too. Damage to several bytes at once is sampled only (fixed seed).
#include <algorithm>
#include <random>

#include "frame/frame_files.h"

namespace {

using namespace frame_files;

const std::string kPixels("\x00\x01\x02\x03\x04\x05\x06\x07\x08\x09\x0a\x0b\x0c\x0d\x0e\x0f", 16);

std::string small_fits() {
  return fits_header(image_cards(16, 4, 2) + Cards{{"BZERO", "32768"}, {"BSCALE", "1"}, {"EXPTIME", "2.5"}}) +
         fits_data(kPixels);
}

std::string small_extension_fits() {
  const Cards table{{"XTENSION", "'BINTABLE'"},
                    {"BITPIX", "8"},
                    {"NAXIS", "2"},
                    {"NAXIS1", "4"},
                    {"NAXIS2", "2"},
                    {"PCOUNT", "0"},
                    {"GCOUNT", "1"},
                    {"TFIELDS", "1"},
                    {"TFORM1", "'1J'"}};
  return fits_header(empty_primary()) + fits_header(table) + fits_data("12345678") +
         fits_header(extension_cards(4, 4, {{"EXTNAME", "'CCD'"}})) + fits_data(kPixels);
}

std::vector<std::string> small_tiffs(const Path& folder) {
  std::vector<std::string> files;
  for (const int compression : {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE}) {
    for (const char* mode : {"wl", "wb", "w8"}) {
      write_tiff(folder / "made.tif", 4, 2, kPixels,
                 {.compression = static_cast<std::uint16_t>(compression), .mode = mode});
      files.push_back(read_bytes(folder / "made.tif"));
    }
  }
  return files;
}

std::vector<std::string> small_pngs(const Path& folder) {
  std::vector<std::string> files;
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
    write_png(folder / "made.png", 4, 2, kPixels, {.interlace = interlace});
    files.push_back(read_bytes(folder / "made.png"));
  }
  return files;
}

const std::string kBinaryPgm = "P5 # c\n4 2 65535\n" + kPixels;
const std::string kTextPgm = "P2 # c\n4 2 255\n0 1 2 3 44 55 66 77\n";

void expect_every_prefix_refused(const Path& path, const std::string& bytes) {
  write_bytes(path, bytes);
  ASSERT_EQ(refusal(path), "");
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    write_bytes(path, bytes.substr(0, n));
    EXPECT_NE(refusal(path), "") << "the first " << n << " of " << bytes.size() << " bytes pass for the whole";
  }
}

TEST(FrameDamage, EveryPrefixOfAFits) { expect_every_prefix_refused(scratch_folder() / "a", small_fits()); }

TEST(FrameDamage, EveryPrefixOfATiff) {
  const Path folder = scratch_folder();
  for (const std::string& bytes : small_tiffs(folder)) expect_every_prefix_refused(folder / "a", bytes);
}

TEST(FrameDamage, EveryPrefixOfAPng) {
  const Path folder = scratch_folder();
  for (const std::string& bytes : small_pngs(folder)) expect_every_prefix_refused(folder / "a", bytes);
}

TEST(FrameDamage, EveryPrefixOfAPgm) {
  const Path folder = scratch_folder();
  expect_every_prefix_refused(folder / "a", kBinaryPgm);
  expect_every_prefix_refused(folder / "a", kTextPgm);
}

// Reads every variant; only returning or throwing Error is allowed, anything else ends the test program.
struct Tally {
  int read = 0;
  int refused = 0;
};

Tally mutate_each_byte(const Path& path, const std::string& bytes, std::size_t end, const std::string& replacements) {
  Tally tally;
  std::string mutant = bytes;
  for (std::size_t i = 0; i < std::min(end, bytes.size()); ++i) {
    for (const char c : replacements) {
      mutant[i] = c;
      write_bytes(path, mutant);
      ++(refusal(path).empty() ? tally.read : tally.refused);
    }
    mutant[i] = static_cast<char>(bytes[i] ^ 0x01);
    write_bytes(path, mutant);
    ++(refusal(path).empty() ? tally.read : tally.refused);
    mutant[i] = bytes[i];
  }
  return tally;
}

TEST(FrameDamage, EveryHeaderByteOfAFits) {
  const Path folder = scratch_folder();
  const std::string replacements("\x00\xff 9-'", 6);
  const std::string small = small_fits();
  const Tally tally = mutate_each_byte(folder / "a", small, 2880, replacements);
  EXPECT_EQ(tally.read + tally.refused, 7 * 2880);
  EXPECT_GT(tally.refused, 100);
  EXPECT_GT(tally.read, 1000) << "comments and padding may change";
  const std::string extension = small_extension_fits();
  mutate_each_byte(folder / "a", extension, extension.size(), "9");
}

TEST(FrameDamage, EveryByteOfTheOtherFormats) {
  const Path folder = scratch_folder();
  std::vector<std::string> files = small_tiffs(folder);
  for (const std::string& png : small_pngs(folder)) files.push_back(png);
  files.push_back(kBinaryPgm);
  files.push_back(kTextPgm);
  const std::string replacements("\x00\xff\x7f 9", 5);
  for (const std::string& bytes : files) {
    const Tally tally = mutate_each_byte(folder / "a", bytes, bytes.size(), replacements);
    EXPECT_GT(tally.refused, 20);
  }
}

TEST(FrameDamage, SeveralBytesAtOnce) {
  const Path folder = scratch_folder();
  std::vector<std::string> files = small_tiffs(folder);
  for (const std::string& png : small_pngs(folder)) files.push_back(png);
  files.insert(files.end(), {small_fits(), small_extension_fits(), kBinaryPgm, kTextPgm});
  std::mt19937 random(20210731);
  for (int i = 0; i < 6000; ++i) {
    std::string bytes = files[random() % files.size()];
    const std::size_t reach = std::min<std::size_t>(bytes.size(), 800);
    for (int k = 0; k < 4; ++k) bytes[random() % reach] = static_cast<char>(random());
    write_bytes(folder / "a", bytes);
    refusal(folder / "a");
  }
}

}  // namespace
