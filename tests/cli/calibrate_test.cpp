// The verb calibrate: the picture of residuals and the bootstrap beside the calibrated instrument, and nothing at all
// where the picture cannot be. Does not prove the calibration itself (tests/calib).
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calib/targets.h"
#include "cli/lab.h"

namespace scatmap::test {
namespace {

class CalibrateVerb : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::path(testing::TempDir()) / ("scatmap-calibrate-" + std::to_string(getpid()));
    fs::create_directories(folder_ / "tmp");
    const fs::path scene = fs::path(SCATMAP_SOURCE_DIR) / "data-synthetic/scenes/mirror-aligned.toml";
    ASSERT_EQ(run_tool({"simulate", scene.string(), "-o", "lab"}, folder_).status, 0);
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  static ToolRun run(const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"calibrate", "lab/targets.csv", "--instrument", "lab/instrument.toml"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_tool(arguments, folder_);
  }
  static inline fs::path folder_;
};

TEST_F(CalibrateVerb, BootstrapStandsBesideTheCovariance) {
  const ToolRun done = run({"-o", "boot.toml", "--bootstrap", "400", "--seed", "9", "--json"});
  ASSERT_EQ(done.status, 0) << done.err;
  const auto out = nlohmann::json::parse(done.out);
  EXPECT_EQ(out["bootstrap"]["trials"], 400);
  EXPECT_EQ(out["bootstrap"]["kind"], "parametric");
  ASSERT_EQ(out["bootstrap"]["directions"].size(), out["directions"].size());
  for (std::size_t k = 0; k < out["directions"].size(); ++k) {
    const double ratio = out["bootstrap"]["directions"][k].at("sigma_mrad").get<double>() /
                         out["directions"][k].at("sigma_mrad").get<double>();
    EXPECT_NEAR(ratio, 1, 3 / std::sqrt(800.0) + 0.05);
  }
  EXPECT_NE(run({"-o", "boot2.toml", "--bootstrap", "30"}).out.find("parametric bootstrap, 30 trials"),
            std::string::npos);
}

TEST_F(CalibrateVerb, DrawsResiduals) {
  ASSERT_EQ(run({"-o", "drawn.toml", "--residuals", "drawn.png"}).status, 0);
  EXPECT_EQ(Lab(folder_).read("drawn.png").substr(1, 3), "PNG");
}

TEST_F(CalibrateVerb, WritesNothingWhereThePictureCannotBe) {
  const ToolRun format = run({"-o", "never.toml", "--residuals", "never.pdf"});
  EXPECT_EQ(format.status, 1);
  EXPECT_NE(format.err.find("never.pdf"), std::string::npos) << format.err;
  Lab(folder_).write("there.png", "something");
  const ToolRun there = run({"-o", "never.toml", "--residuals", "there.png"});
  EXPECT_EQ(there.status, 1);
  EXPECT_NE(there.err.find("there.png"), std::string::npos) << there.err;
  EXPECT_EQ(Lab(folder_).read("there.png"), "something");
  EXPECT_FALSE(fs::exists(folder_ / "never.toml"));
}

}  // namespace
}  // namespace scatmap::test
