// The verb spots on simulated frames: targets with the right kind, angles, tilt and centroid; frames without a spot are
// skipped by name. Does not prove the centroids' statistics (tests/calib/spots_statistics_test.cpp).
#include <fitsio.h>
#include <gtest/gtest.h>

#include <cmath>

#include "calib/targets.h"
#include "cli/lab.h"
#include "scatmap/base/units.h"

namespace scatmap::test {
namespace {

class SpotsVerb : public testing::Test {
 protected:
  // Simulated once; each test works in the same folder, on files of its own.
  static void SetUpTestSuite() {
    folder_ = fs::path(testing::TempDir()) / ("scatmap-spots-" + std::to_string(getpid()));
    fs::create_directories(folder_ / "tmp");
    const fs::path scene = fs::path(SCATMAP_SOURCE_DIR) / "data-synthetic/scenes/mirror-frames.toml";
    ASSERT_EQ(run_tool({"simulate", scene.string(), "-o", "lab"}, folder_).status, 0);
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  static ToolRun run(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--instrument", "lab/instrument.toml"});
    return run_tool(arguments, folder_);
  }
  static std::string frame(int number) {
    return "lab/frames/target_" + std::to_string(1000 + number).substr(1) + ".fits";
  }
  // The frame of a target with every pixel at one level.
  static std::string without_spot(int number) {
    const std::string name = "blank_" + std::to_string(number) + ".fits";
    fs::copy_file(folder_ / frame(number), folder_ / name, fs::copy_options::overwrite_existing);
    fitsfile* file = nullptr;
    int status = 0;
    fits_open_diskfile(&file, (folder_ / name).c_str(), READWRITE, &status);
    std::vector<unsigned short> level(512 * 512);
    for (std::size_t i = 0; i < level.size(); ++i) level[i] = static_cast<unsigned short>(300 + i * 2654435761U % 9);
    fits_write_img(file, TUSHORT, 1, static_cast<LONGLONG>(level.size()), level.data(), &status);
    fits_close_file(file, &status);
    EXPECT_EQ(status, 0);
    return name;
  }
  // The frame of a target, with one card taken out.
  static std::string without_card(int number, const char* key) {
    const std::string name = std::string("no_") + key + "_" + std::to_string(number) + ".fits";
    fs::copy_file(folder_ / frame(number), folder_ / name, fs::copy_options::overwrite_existing);
    fitsfile* file = nullptr;
    int status = 0;
    fits_open_diskfile(&file, (folder_ / name).c_str(), READWRITE, &status);
    fits_delete_key(file, key, &status);
    fits_close_file(file, &status);
    EXPECT_EQ(status, 0);
    return name;
  }
  static void write(const std::string& name, const std::string& text) { Lab(folder_).write(name, text); }
  static calib::TargetList targets(const std::string& name) { return calib::read_targets(folder_ / name); }

  static inline fs::path folder_;
};

TEST_F(SpotsVerb, TargetsAreTheSimulatorsAnglesAndPlaces) {
  std::vector<std::string> arguments{"spots"};
  for (int i = 1; i <= 14; ++i) arguments.push_back(frame(i));
  arguments.insert(arguments.end(), {"-o", "found.csv"});
  const ToolRun done = run(arguments);
  ASSERT_EQ(done.status, 0) << done.err;
  const calib::TargetList found = targets("found.csv"), truth = targets("lab/truth/targets.csv"),
                          commanded = targets("lab/targets.csv");
  ASSERT_EQ(found.targets.size(), truth.targets.size());
  for (std::size_t i = 0; i < found.targets.size(); ++i) {
    const calib::Target& t = found.targets[i];
    EXPECT_EQ(t.kind, truth.targets[i].kind);  // from TARGET
    EXPECT_NEAR(t.stage_rad, commanded.targets[i].stage_rad, 1e-12);
    EXPECT_NEAR(t.arm_rad, commanded.targets[i].arm_rad, 1e-12);
    EXPECT_NEAR(t.tilt_rad, commanded.targets[i].tilt_rad, 1e-12);  // from TILTDEG
    EXPECT_LE(std::abs(t.column_px - truth.targets[i].column_px), 5 * t.sigma_px);
    EXPECT_LE(std::abs(t.row_px - truth.targets[i].row_px), 5 * t.sigma_px);
    EXPECT_LE(t.sigma_px, 0.05);
  }
}

// Frames to calibration with nothing stated beside the frames: the direct beams must not be lost on the way.
TEST_F(SpotsVerb, CalibrateUsesTheDirectBeamsOfTheFrames) {
  std::vector<std::string> arguments{"spots"};
  for (int i = 1; i <= 14; ++i) arguments.push_back(frame(i));
  arguments.insert(arguments.end(), {"-o", "all.csv"});
  const ToolRun found = run(arguments);
  ASSERT_EQ(found.status, 0) << found.err;
  EXPECT_EQ(found.err.find("nothing says its kind"), std::string::npos) << found.err;
  const ToolRun done = run({"calibrate", "all.csv", "-o", "calibrated.toml", "--json"});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_EQ((done.out + done.err).find("direct-beam frame"), std::string::npos) << done.out << done.err;
}

TEST_F(SpotsVerb, FrameWithoutAKindThatNoMirrorCanHaveMadeIsNoted) {
  const std::string direct = without_card(13, "TARGET"), mirror = without_card(1, "TARGET");
  const ToolRun done = run({"spots", direct, mirror, "-o", "doubt.csv"});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_NE(done.err.find("note: " + direct + ": nothing says its kind"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("TARGET = 'direct'"), std::string::npos);
  EXPECT_EQ(done.err.find("note: " + mirror), std::string::npos) << done.err;
  const ToolRun stated = run({"spots", direct, "--kind", "direct", "-o", "no_doubt.csv"});
  ASSERT_EQ(stated.status, 0) << stated.err;
  EXPECT_EQ(stated.err.find("nothing says its kind"), std::string::npos) << stated.err;
  EXPECT_EQ(targets("no_doubt.csv").targets.at(0).kind, calib::TargetKind::kDirect);
}

TEST_F(SpotsVerb, FrameWithoutALineFallsBackToItsHeader) {
  write("some.csv", "file,arm_deg\n" + frame(1) + ",20.5\n");
  const ToolRun done = run({"spots", frame(1), frame(2), "--angles", "some.csv", "-o", "some_found.csv"});
  ASSERT_EQ(done.status, 0) << done.err;
  const calib::TargetList found = targets("some_found.csv"), commanded = targets("lab/targets.csv");
  ASSERT_EQ(found.targets.size(), 2U);
  EXPECT_NEAR(found.targets[0].arm_rad, 20.5 * kRadPerDeg, 1e-12);
  EXPECT_NEAR(found.targets[1].arm_rad, commanded.targets[1].arm_rad, 1e-12);
  EXPECT_NE(done.err.find(frame(2) + ": has no line in some.csv"), std::string::npos) << done.err;
  const std::string poseless = without_card(2, "ARMDEG");
  const ToolRun neither = run({"spots", poseless, "--angles", "some.csv", "-o", "never.csv"});
  EXPECT_EQ(neither.status, 1);
  EXPECT_NE(neither.err.find(poseless + ": the arm angle is not stated"), std::string::npos) << neither.err;
}

TEST_F(SpotsVerb, FramesWithoutASpotAreSkippedByName) {
  const std::string blank = without_spot(2);
  const ToolRun done = run({"spots", frame(1), blank, frame(3), "-o", "two.csv", "--json"});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_EQ(targets("two.csv").targets.size(), 2U);
  EXPECT_NE(done.err.find("skipped: " + blank + ": no spot stands out"), std::string::npos) << done.err;
  const std::size_t skipped = done.out.find("\"skipped\"");
  ASSERT_NE(skipped, std::string::npos);
  EXPECT_NE(done.out.find(blank, skipped), std::string::npos) << done.out;
}

TEST_F(SpotsVerb, NoSpotAtAllIsAnError) {
  const std::string one = without_spot(4), two = without_spot(5);
  const ToolRun done = run({"spots", one, two, "-o", "none.csv"});
  EXPECT_EQ(done.status, 1);
  EXPECT_NE(done.err.find(one), std::string::npos) << done.err;
  EXPECT_NE(done.err.find(two), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "none.csv"));
}

TEST_F(SpotsVerb, CommandLineOverridesTheHeader) {
  ASSERT_EQ(run({"spots", frame(1), "--tilt-deg", "0.25", "--arm-deg", "21", "-o", "one.csv"}).status, 0);
  const calib::TargetList one = targets("one.csv");
  ASSERT_EQ(one.targets.size(), 1U);
  EXPECT_NEAR(one.targets[0].tilt_rad, 0.25 * kRadPerDeg, 1e-12);
  EXPECT_NEAR(one.targets[0].arm_rad, 21 * kRadPerDeg, 1e-12);
  EXPECT_NEAR(one.targets[0].stage_rad, 10 * kRadPerDeg, 1e-12);
}

// A mirror's tilt in the header of a frame said to be a direct beam is a contradiction, not ignored.
TEST_F(SpotsVerb, TiltedDirectBeamIsRefused) {
  const ToolRun done = run({"spots", frame(1), "--kind", "direct", "-o", "never.csv"});
  EXPECT_EQ(done.status, 1);
  EXPECT_NE(done.err.find("direct beam"), std::string::npos) << done.err;
}

}  // namespace
}  // namespace scatmap::test
