// targets.csv: what is well-formed is read bit for bit, what is not is refused with file, line and column. Does not
// prove that the targets make sense together; calibrate does that.
#include "calib/targets.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "data-synthetic/simulate.h"
#include "scatmap/base/error.h"
#include "scatmap/base/units.h"

namespace scatmap::calib {
namespace {

const std::string kHeader = "kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px\n";
const std::string kWithMount = "kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px,mount,file\n";

TEST(Targets, ReadsWhatTheDesignSays) {
  const TargetList list = parse_targets("# a comment\n" + kWithMount +
                                            "specular,20,40,0.5,100.25,-3,0.05,flat-a,f1.fits\r\n\n"
                                            "direct, 0 ,180,0,1e2,+7.5,0.1,,\n"
                                            "specular,21,42,0,1,2,0.05,flat b,\n",
                                        "t.csv");
  ASSERT_EQ(list.targets.size(), 3u);
  EXPECT_EQ(list.mounts, (std::vector<std::string>{"flat-a", "flat b"}));
  const Target& a = list.targets[0];
  EXPECT_EQ(a.kind, TargetKind::kSpecular);
  EXPECT_EQ(a.stage_rad, 20 * kRadPerDeg);
  EXPECT_EQ(a.arm_rad, 40 * kRadPerDeg);
  EXPECT_EQ(a.tilt_rad, 0.5 * kRadPerDeg);
  EXPECT_EQ(a.column_px, 100.25);
  EXPECT_EQ(a.row_px, -3);
  EXPECT_EQ(a.file, "f1.fits");
  EXPECT_EQ(a.line, 3);
  EXPECT_EQ(list.targets[1].kind, TargetKind::kDirect);
  EXPECT_EQ(list.targets[1].row_px, 7.5);
  EXPECT_EQ(list.targets[2].mount, 1u);
  EXPECT_EQ(label(list, a), "t.csv:3 (f1.fits)");
  EXPECT_EQ(label(list, list.targets[2]), "t.csv:6");
}

TEST(Targets, ColumnsMayStandInAnyOrder) {
  const TargetList list =
      parse_targets("row_px,column_px,sigma_px,tilt_deg,arm_deg,stage_deg,kind\n1,2,3,4,5,6,specular\n", "t.csv");
  EXPECT_EQ(list.targets[0].row_px, 1);
  EXPECT_EQ(list.targets[0].column_px, 2);
  EXPECT_EQ(list.targets[0].sigma_px, 3);
  EXPECT_EQ(list.targets[0].stage_rad, 6 * kRadPerDeg);
}

TEST(Targets, TextKeepsEveryBit) {
  TargetList list{"a", {"m", "n"}, {}};
  for (int i = 0; i < 200; ++i) {
    const double x = (i + 1) / 7.0;
    Target t{i % 3 == 0 ? TargetKind::kDirect : TargetKind::kSpecular,
             x / 3 * kRadPerDeg,
             2 * x * kRadPerDeg,
             0,
             1000 / x,
             -x,
             x / 100,
             0,
             "f",
             0};
    if (t.kind == TargetKind::kSpecular) {
      t.mount = i % 2 == 0 ? 1 : 0;
      t.tilt_rad = x / 100 * kRadPerDeg;
    }
    list.targets.push_back(t);
  }
  const TargetList once = parse_targets(to_csv(list), "b"), twice = parse_targets(to_csv(once), "c");
  ASSERT_EQ(twice.targets.size(), list.targets.size());
  for (std::size_t i = 0; i < list.targets.size(); ++i) {
    const Target &a = once.targets[i], &b = twice.targets[i];
    EXPECT_EQ(a.column_px, list.targets[i].column_px);
    EXPECT_EQ(a.row_px, list.targets[i].row_px);
    EXPECT_EQ(a.sigma_px, list.targets[i].sigma_px);
    EXPECT_EQ(a.stage_rad, b.stage_rad);
    EXPECT_EQ(a.tilt_rad, b.tilt_rad);
    EXPECT_NEAR(a.arm_rad, list.targets[i].arm_rad, 1e-15);
    EXPECT_EQ(once.mounts[a.mount],
              a.kind == TargetKind::kSpecular ? list.mounts[list.targets[i].mount] : once.mounts[a.mount]);
  }
}

TEST(Targets, ReadsWhatSimulateWrites) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "calib_targets_simulated";
  std::filesystem::remove_all(folder);
  synth::simulate(std::string(SCATMAP_SOURCE_DIR) + "/data-synthetic/scenes/mirror-every-parameter.toml", folder,
                  Overwrite::kKeep, {"test", "test", {}});
  const TargetList list = read_targets(folder / "targets.csv");
  EXPECT_EQ(list.targets.size(), 60u);
  EXPECT_EQ(list.mounts, (std::vector<std::string>{"flat-a", "flat-b"}));
  std::filesystem::remove_all(folder);
}

struct Bad {
  std::string text;
  const char* expected;  // part of the message
};

TEST(Targets, RefusesWithFileLineAndColumn) {
  const std::string good = "specular,20,40,0,100,100,0.05\n";
  const Bad cases[] = {
      {"", "t.csv: is empty"},
      {"\n\n# nothing\n", "t.csv: is empty"},
      {kHeader, "t.csv: lists no target"},
      {"kind,stage_deg\n", "t.csv:1: lacks the column arm_deg"},
      {"stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px\n", "t.csv:1: lacks the column kind"},
      {"kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma\n", "'sigma'"},
      {"kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px,kind\n", "t.csv:1: names a column twice, got kind"},
      {"kind;stage_deg;arm_deg\n", "names a column that targets do not have"},
      {kHeader + good + "# again\n" + good, "t.csv:4: repeats line 2"},
      {kHeader + good + "specular,20.0,40,0,100.000000001,100,0.05\n", "t.csv:3: repeats line 2"},
      {kHeader + "specular,20,40,0,100,100\n", "t.csv:2: has the wrong number of fields, got 6, expected 7"},
      {kHeader + "specular,20,40,0,100,100,0.05,extra\n", "t.csv:2: has the wrong number of fields, got 8"},
      {kHeader + good + "\n" + "mirror,20,40,0,100,100,0.05\n", "t.csv:4: kind: is not known, got 'mirror'"},
      {kHeader + "Specular,20,40,0,100,100,0.05\n", "specular or direct"},
      {kHeader + ",20,40,0,100,100,0.05\n", "kind: is not known"},
      {kHeader + "specular,x,40,0,100,100,0.05\n", "t.csv:2: stage_deg: is not a number, got 'x'"},
      {kHeader + "specular,,40,0,100,100,0.05\n", "stage_deg: is not a number"},
      {kHeader + "specular,20,40 deg,0,100,100,0.05\n", "arm_deg: is not a number"},
      {kHeader + "specular,20,4 0,0,100,100,0.05\n", "arm_deg: is not a number"},
      {kHeader + "specular,20,400,0,100,100,0.05\n", "arm_deg: is out of range, got 400"},
      {kHeader + "specular,20,40,90,100,100,0.05\n", "tilt_deg: is out of range"},
      {kHeader + "specular,20,40,0,nan,100,0.05\n", "column_px"},
      {kHeader + "specular,20,40,0,100,inf,0.05\n", "row_px"},
      {kHeader + "specular,20,40,0,1e400,100,0.05\n", "column_px"},
      {kHeader + "specular,20,40,0,100,1e9,0.05\n", "row_px: is out of range"},
      {kHeader + "specular,20,40,0,100,100,0\n", "sigma_px: is out of range"},
      {kHeader + "specular,20,40,0,100,100,-1\n", "sigma_px: is out of range"},
      {kHeader + "specular,20,40,0,100,100,nan\n", "sigma_px"},
      {kHeader + "specular,20,40,0,0x10,100,0.05\n", "column_px: is not a number"},
      {kHeader + "specular,20,40,0,1.5.2,100,0.05\n", "column_px: is not a number"},
      {kHeader + "direct,0,180,0.5,100,100,0.05\n", "tilt_deg: is given for a direct beam"},
      {kWithMount + "direct,0,180,0,100,100,0.05,flat,\n", "mount: is given for a direct beam"},
      {kWithMount + "specular,20,40,0,100,100,0.05,a\\b,\n", "mount: is not a plain name"},
      {kWithMount + "specular,20,40,0,100,100,0.05,\"a\",\n", "quotation mark"},
      {kWithMount + "specular,20,40,0,100,100,0.05,a;b=[x],\n", "mount: is not a plain name"},
      {std::string("\x89PNG\r\n\x1a\n\0\0", 10), "t.csv:1"},
  };
  for (const Bad& c : cases) {
    try {
      parse_targets(c.text, "t.csv");
      ADD_FAILURE() << "accepted: " << c.text;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(c.expected), std::string::npos) << e.what();
      EXPECT_EQ(std::string(e.what()).rfind("t.csv", 0), 0u) << e.what();
    }
  }
}

TEST(Targets, MissingFileIsNamed) {
  try {
    read_targets("/nowhere/targets.csv");
    FAIL() << "read a file that does not exist";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("/nowhere/targets.csv"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace scatmap::calib
