// The picture of spot residuals: what the script states is what the numbers say. Does not prove that it looks well.
#include "scatmap/report/residual_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"

namespace scatmap {
namespace {

namespace fs = std::filesystem;

struct Drawn {
  std::string script, data;
  std::uintmax_t picture_bytes;
};

Drawn drawn(const std::vector<SpotResidual>& spots, const std::string& name) {
  const fs::path folder = fs::path(testing::TempDir()) / "residual_picture_test";
  fs::create_directories(folder);
  const fs::path target = folder / name;
  draw_spot_residuals(spots, 1000, 750, "a title", target, {Overwrite::kForce, true});
  const std::string stem = target.stem().string();
  return {read_text_file(folder / (stem + ".gp")), read_text_file(folder / (stem + ".dat")), fs::file_size(target)};
}

// Diagonal 1250 px, a twelfth is 104 px: ten residuals of 0.03 px are drawn 2000 times larger, 60 px long.
TEST(ResidualPicture, MagnificationIsARoundNumberThatKeepsArrowsShort) {
  std::vector<SpotResidual> spots;
  for (int i = 0; i < 10; ++i) spots.push_back({100.0 * i, 300, 0.03, 0, 1, i == 0, false});
  const Drawn d = drawn(spots, "short.png");
  EXPECT_NE(d.script.find("arrows are 2000 times the distance"), std::string::npos) << d.script;
  EXPECT_NE(d.script.find("0.02 px of residual"), std::string::npos);
  EXPECT_GT(d.picture_bytes, 2000U);
  std::istringstream lines(d.data);
  int arrows = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    std::istringstream fields(line);
    double column = 0, row = 0, along = 0, across = 0;
    ASSERT_TRUE(fields >> column >> row >> along >> across) << line;
    EXPECT_NEAR(along, 60, 1e-9);
    EXPECT_EQ(across, 0);
    ++arrows;
  }
  EXPECT_EQ(arrows, 10);
}

TEST(ResidualPicture, OutliersAreCrossesWithTheirDistance) {
  std::vector<SpotResidual> spots{{10, 20, 0.1, 0, 1, false, false}, {500, 600, 40, 3, 123.44, false, true}};
  spots.push_back({700, 100, std::nan(""), std::nan(""), HUGE_VAL, false, true});
  const Drawn d = drawn(spots, "outliers.svg");
  EXPECT_NE(d.script.find("123.4 σ"), std::string::npos);
  EXPECT_NE(d.script.find("not on the detector"), std::string::npos);
  EXPECT_NE(d.data.find("500 600 0 0"), std::string::npos);
  EXPECT_NE(d.script.find("left out"), std::string::npos);
  EXPECT_EQ(d.script.find("direct beam"), std::string::npos);
}

TEST(ResidualPicture, NothingToDrawIsAnError) {
  EXPECT_THROW(draw_spot_residuals({}, 10, 10, "t", testing::TempDir() + "none.png"), Error);
}

}  // namespace
}  // namespace scatmap
