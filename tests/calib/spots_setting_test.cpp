// Where a frame's angles come from: header, angles.csv and their combination; refusals name file and line. Does not
// test the command line itself.
#include "calib/spots_setting.h"

#include <gtest/gtest.h>

#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"
#include "scatmap/base/units.h"

namespace scatmap::calib {
namespace {

std::filesystem::path csv(const std::string& text) {
  const std::filesystem::path path = testing::TempDir() + "spots_setting_angles.csv";
  write_text_file(path, text, Overwrite::kForce);
  return path;
}

std::string refusal(const std::string& text) {
  try {
    SettingTable::read(csv(text));
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

TEST(SpotSetting, TableGivesALineByFileOrByName) {
  const SettingTable table =
      SettingTable::read(csv("# bench "
                             "2\nfile,kind,stage_deg,arm_deg,tilt_deg,mount\n\nframes/"
                             "a.fits,specular,10,20.5,-0.4,m1\nframes/b.fits,direct,,+180,,\n"));
  const auto a = table.find(testing::TempDir() + "frames/../frames/a.fits");
  ASSERT_TRUE(a.has_value());
  EXPECT_EQ(a->kind, TargetKind::kSpecular);
  EXPECT_EQ(a->stage_deg, 10);
  EXPECT_EQ(a->tilt_deg, -0.4);
  EXPECT_EQ(a->mount, "m1");
  const auto b = table.find("elsewhere/b.fits");
  ASSERT_TRUE(b.has_value());
  EXPECT_EQ(b->arm_deg, 180);
  EXPECT_FALSE(b->stage_deg.has_value());
  EXPECT_FALSE(table.find("c.fits").has_value());
}

TEST(SpotSetting, TargetsFileServesAgain) {
  const SettingTable table = SettingTable::read(
      csv("kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px,mount,file\nspecular,1,2,0,5,6,0.1,m,x.fits\n"));
  EXPECT_EQ(table.find("x.fits")->arm_deg, 2);
}

TEST(SpotSetting, FirstStatementWinsAndHeaderFillsIn) {
  Frame frame;
  frame.header.stage_deg = 7;
  frame.header.arm_deg = 8;
  const SpotSetting s = combined({{}, 9, {}, {}, {}}, header_setting(frame));
  const Target t = target_of(s, "f.fits");
  EXPECT_EQ(t.kind, TargetKind::kSpecular);
  EXPECT_DOUBLE_EQ(t.stage_rad, 9 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(t.arm_rad, 8 * kRadPerDeg);
  EXPECT_EQ(t.tilt_rad, 0);
}

TEST(SpotSetting, RefusalsNameFileLineAndReason) {
  const struct {
    const char* text;
    const char* words;
  } cases[] = {{"", "lists no frame"},
               {"kind,stage_deg\nspecular,1\n", "angles.csv:1: lacks the column file"},
               {"file,angle\na,1\n", "'angle'"},
               {"file,kind,kind\na,direct,direct\n", "twice"},
               {"file,stage_deg\na,1,2\n", "angles.csv:2: has the wrong number of fields"},
               {"file,stage_deg\na,1e3\n", "angles.csv:2: stage_deg"},
               {"file,stage_deg\na,nan\n", "angles.csv:2: stage_deg"},
               {"file,kind\na,mirror\n", "'mirror'"},
               {"file,kind\n,direct\n", "angles.csv:2: file"}};
  for (const auto& c : cases)
    EXPECT_NE(refusal(c.text).find(c.words), std::string::npos) << c.text << " -> " << refusal(c.text);
}

TEST(SpotSetting, AmbiguityAndMissingAnglesAreRefused) {
  const SettingTable table = SettingTable::read(csv("file,stage_deg\nx/a.fits,1\ny/a.fits,2\n"));
  EXPECT_THROW(table.find("z/a.fits"), Error);
  EXPECT_EQ(table.find(testing::TempDir() + "y/a.fits")->stage_deg, 2);
  EXPECT_THROW(target_of({{}, 1, {}, {}, {}}, "f.fits"), Error);
  EXPECT_THROW(target_of({TargetKind::kDirect, 1, 180, 0.2, {}}, "f.fits"), Error);
}

}  // namespace
}  // namespace scatmap::calib
