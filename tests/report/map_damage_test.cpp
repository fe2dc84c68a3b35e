// Maps whose tables lie about their size or content are refused, not read. Does not prove it for every lie:
// tests/fuzz looks for more.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "frame/fits_sums.h"
#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"
#include "scatmap/base/units.h"
#include "scatmap/report/map_fits.h"

namespace scatmap {
namespace {
namespace fs = std::filesystem;

class MapDamage : public testing::Test {
 protected:
  void SetUp() override {
    file_ = fs::path(testing::TempDir()) / ("scatmap-damage-" + std::to_string(getpid()) + ".fits");
    BrdfMap map;
    map.instrument =
        parse_instrument("[detector]\ncolumns = 3\nrows = 2\npitch_um = [50, 50]\ndistance_mm = 325\n", "example");
    map.pose = {20 * kRadPerDeg, 40 * kRadPerDeg};
    map.wavelength_m = 632.8 * kMetrePerNm;
    map.angles = angle_map(map.instrument, map.pose);
    map.mask = Grid<Mask>(2, 3, Mask{0});
    map.brdf_per_sr = Grid<double>(2, 3, 1.0);
    map.u_random_per_sr = Grid<float>(2, 3, 0.1F);
    map.scale.causes = {{"a", Distribution::kNormal, 0.2, 1, false, 0},
                        {"b", Distribution::kNormal, 0.1, -1, false, 0}};
    map.scale.correlation = Eigen::MatrixXd::Identity(2, 2);
    map.scale.correlation(0, 1) = map.scale.correlation(1, 0) = 0.5;
    write_map_fits(map, file_, Precision::kSingle, Overwrite::kForce);
    good_ = without_fits_sums(summed());
  }
  std::string summed() const { return read_text_file(file_); }
  void TearDown() override { fs::remove(file_); }

  // Where the header of an extension begins.
  std::size_t extension(const std::string& name) const {
    const std::size_t at = good_.rfind("XTENSION", good_.find("'" + name + "'"));
    EXPECT_NE(at, std::string::npos) << name;
    return at;
  }
  std::string with_cards(const std::string& name, const std::vector<std::pair<std::string, std::string>>& cards) const {
    std::string bytes = good_;
    for (const auto& [key, value] : cards) {
      std::string text = key;
      text.resize(8, ' ');
      const std::size_t at = good_.find(text + "=", extension(name));
      text += "= " + std::string(value.size() < 20 && value[0] != '\'' ? 20 - value.size() : 0, ' ') + value;
      text.resize(80, ' ');
      bytes.replace(at, 80, text);
    }
    return bytes;
  }
  void write(const std::string& bytes) { std::ofstream(file_, std::ios::binary | std::ios::trunc) << bytes; }
  std::string said(const std::string& bytes) {
    write(bytes);
    try {
      read_map_fits(file_);
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  }

  fs::path file_;
  std::string good_;
};

TEST_F(MapDamage, TheMapItselfIsRead) {
  EXPECT_EQ(said(summed()), "accepted");
  EXPECT_EQ(said(good_), "accepted");
}

// One bit of the data, of a card, of a table.
TEST_F(MapDamage, WhatIsNotAsItWasSummed) {
  const std::string whole = summed();
  const auto flipped = [&](std::size_t at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    return said(bytes);
  };
  const std::size_t primary_data = (whole.find("END     ") / 2880 + 1) * 2880;
  EXPECT_NE(flipped(primary_data + 3).find("(DATASUM): is not the sum of the data"), std::string::npos);
  const std::size_t wavelength = whole.find("WAVELEN =");
  EXPECT_NE(flipped(whole.find_first_of("0123456789", wavelength)).find("(CHECKSUM): is not that of header and data"),
            std::string::npos);
  const std::size_t table = whole.find("END     ", whole.find("'INSTRUMENT'"));
  EXPECT_NE(flipped((table / 2880 + 1) * 2880).find("(DATASUM): is not the sum"), std::string::npos);
}

// Numbers that follow from others were ignored where they said something else.
TEST_F(MapDamage, DerivedNumbersThatDoNotFollow) {
  const auto with_number = [&](const std::string& key, const std::string& value) {
    std::string bytes = good_;
    std::string card = key + "= " + std::string(20 - value.size(), ' ') + value;
    card.resize(80, ' ');
    bytes.replace(bytes.find(key + "="), 80, card);
    return said(bytes);
  };
  EXPECT_NE(with_number("THETAI  ", "21.").find("THETAI: does not follow from STAGERAD"), std::string::npos);
  EXPECT_NE(with_number("USCALE  ", "0.01").find("USCALE: does not follow from the table COMMON"), std::string::npos);
  std::string bytes = good_;
  const std::size_t data = (bytes.find("END     ", bytes.find("'UNCERT  '")) / 2880 + 1) * 2880;
  bytes.replace(data + 4, 4, std::string("\x3f\x80\0\0", 4));  // 1 instead of 0.1
  EXPECT_NE(said(bytes).find("UNCERT, column 1, row 0: is not the norm"), std::string::npos) << said(bytes);
}

// Two thousand million rows of nothing fit any file; they took minutes to read.
TEST_F(MapDamage, RowsWithoutContent) {
  const std::string rows =
      with_cards("INSTRUMENT", {{"NAXIS1", "0"}, {"NAXIS2", "2147483647"}, {"TFORM1", "'0A      '"}});
  EXPECT_NE(said(rows).find("INSTRUMENT: has too many rows, got 2147483647"), std::string::npos) << said(rows);
}

TEST_F(MapDamage, ColumnsBeyondTheStandard) {
  const std::string columns = with_cards("INSTRUMENT", {{"TFIELDS", "2147483648"}});
  EXPECT_NE(said(columns).find("(TFIELDS): is out of range"), std::string::npos) << said(columns);
}

// Big-endian doubles in the rows of COMMON_CORRELATION: CAUSE_A, CAUSE_B, CORRELATION.
TEST_F(MapDamage, CorrelationsOfNoCauses) {
  const std::size_t header = extension("COMMON_CORRELATION");
  const std::size_t data = (good_.find("END     ", header) / 2880 + 1) * 2880;
  const std::string nan("\x7f\xf8\0\0\0\0\0\0", 8), huge("\x7f\xe0\0\0\0\0\0\0", 8), two("\x40\0\0\0\0\0\0\0", 8);
  for (const std::string& number : {nan, huge}) {
    for (std::size_t column = 0; column < 3; ++column) {
      std::string bytes = good_;
      bytes.replace(data + 8 * column, 8, number);
      EXPECT_NE(said(bytes).find("COMMON_CORRELATION, row 1: is no correlation"), std::string::npos) << said(bytes);
    }
  }
  std::string bytes = good_;
  bytes.replace(data + 16, 8, two);
  EXPECT_NE(said(bytes).find("is no correlation"), std::string::npos) << said(bytes);
}

TEST_F(MapDamage, NumbersThatAreNone) {
  const auto written = [&](auto&& spoil) {
    BrdfMap map = read_map_fits(file_);
    spoil(map);
    write_map_fits(map, file_, Precision::kSingle, Overwrite::kForce);
    return said(without_fits_sums(summed()));
  };
  EXPECT_EQ(written([](BrdfMap&) {}), "accepted");
  EXPECT_NE(written([](BrdfMap& m) { m.brdf_per_sr(1, 2) = std::nan(""); }).find("BRDF, column 2, row 1"),
            std::string::npos);
  write(good_);
  EXPECT_NE(written([](BrdfMap& m) { m.u_random_per_sr(0, 1) = -1; }).find("U_RANDOM, column 1, row 0"),
            std::string::npos);
  write(good_);
  EXPECT_NE(written([](BrdfMap& m) { m.scale.causes[1].half_width = std::nan(""); }).find("COMMON, row 2"),
            std::string::npos);
  write(good_);
  EXPECT_NE(written([](BrdfMap& m) { m.scale.causes[0].half_width = -5; }).find("COMMON, row 1"), std::string::npos);
  write(good_);
  EXPECT_NE(written([](BrdfMap& m) { m.scale.causes[0].sensitivity = HUGE_VAL; }).find("COMMON, row 1"),
            std::string::npos);
  std::string bananas = good_;
  const std::size_t at = bananas.rfind("normal");
  bananas.replace(at, 6, "banana");
  EXPECT_NE(said(bananas).find("banana"), std::string::npos);
}

}  // namespace
}  // namespace scatmap
