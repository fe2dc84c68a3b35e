// scatmap angles: which method a tolerance takes, what --json and the header say of it, and that the files of two
// methods differ by no more than their bounds. Does not prove the bounds (tests/accuracy).
#include <fitsio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "cli/run_tool.h"

namespace scatmap::test {
namespace {
namespace fs = std::filesystem;

class AnglesVerb : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / "angles";
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "tmp");
    std::ofstream(folder_ / "bench.toml") << "[detector]\ncolumns = 300\nrows = 200\npitch_um = [30.0, 30.0]\n"
                                             "distance_mm = 325.0\n";
  }
  ToolRun angles(std::vector<std::string> more) const {
    std::vector<std::string> arguments{"angles", "bench.toml", "--stage-deg", "20", "--arm-deg", "43", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_tool(arguments, folder_);
  }
  struct Image {
    std::vector<double> values;
    std::string method;
    double bound_rad = 0;
    int bits = 0;
  };
  Image theta(const std::string& name) const {
    Image image;
    fitsfile* file = nullptr;
    int status = 0, nulls = 0;
    char text[FLEN_VALUE] = {};
    fits_open_diskfile(&file, (folder_ / name).c_str(), READONLY, &status);
    fits_get_img_type(file, &image.bits, &status);
    fits_read_key(file, TSTRING, "ANGMETH", text, nullptr, &status);
    fits_read_key(file, TDOUBLE, "ANGBOUND", &image.bound_rad, nullptr, &status);
    image.values.resize(300 * 200);
    fits_read_img(file, TDOUBLE, 1, static_cast<LONGLONG>(image.values.size()), nullptr, image.values.data(), &nulls,
                  &status);
    fits_close_file(file, &status);
    EXPECT_EQ(status, 0);
    image.method = text;
    return image;
  }
  fs::path folder_;
};

TEST_F(AnglesVerb, TheToleranceChoosesTheMethodAndTheFileSaysWhich) {
  ASSERT_EQ(angles({"-o", "plain.fits", "--method", "exact"}).status, 0);
  const Image plain = theta("plain.fits");
  EXPECT_EQ(plain.method, "exact");
  EXPECT_EQ(plain.bits, DOUBLE_IMG);
  for (const auto& [tolerance, method] :
       {std::pair{"0.05", "tile"}, std::pair{"100000", "linear"}, std::pair{"1e-9", "vector"}}) {
    const std::string name = std::string(method) + ".fits";
    const ToolRun run = angles({"-o", name, "--tolerance-px", tolerance});
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_NE(run.out.find("\"method\": \"" + std::string(method) + "\""), std::string::npos) << run.out;
    const Image image = theta(name);
    EXPECT_EQ(image.method, method);
    EXPECT_EQ(image.bits, image.method == "vector" ? DOUBLE_IMG : FLOAT_IMG);
    double worst = 0;
    for (std::size_t i = 0; i < image.values.size(); ++i) {
      const double difference = std::abs(image.values[i] - plain.values[i]) * 3.14159265358979 / 180;
      if (!(difference <= worst)) worst = difference;
    }
    constexpr double kDegrees_rad = 4e-16;  // both files' numbers were rounded to degrees
    EXPECT_LE(worst, image.bound_rad + plain.bound_rad + kDegrees_rad) << method;
  }
}

TEST_F(AnglesVerb, WithoutAToleranceItIsAThousandthOfAPixel) {
  const ToolRun run = angles({"-o", "default.fits"});
  ASSERT_EQ(run.status, 0) << run.err;
  const Image image = theta("default.fits");
  constexpr double kPixel_rad = 30e-6 / 0.325;
  EXPECT_LE(image.bound_rad, 0.001 * kPixel_rad * 1.01);
}

TEST_F(AnglesVerb, BadUsage) {
  EXPECT_EQ(angles({"-o", "a.fits", "--method", "fast"}).status, 2);
  EXPECT_EQ(angles({"-o", "a.fits", "--tolerance-px", "-1"}).status, 2);
  EXPECT_EQ(angles({"-o", "a.fits", "--tolerance-px", "0.1", "--method", "tile"}).status, 2);
  EXPECT_FALSE(fs::exists(folder_ / "a.fits"));
}

}  // namespace
}  // namespace scatmap::test
