// The verb export: what it writes reads back as the same detector, and what it cannot do is refused in words. Does not
// prove that mrcal (tests/calib/export_cameramodel_test.cpp) or pyFAI read the files.
#include <gtest/gtest.h>

#include <regex>

#include "calib/instrument_from_poni.h"
#include "cli/lab.h"
#include "scatmap/angles/angle_map.h"
#include "scatmap/angles/lens.h"
#include "scatmap/base/units.h"

namespace scatmap::test {
namespace {

class Export : public testing::Test {
 protected:
  Export() : lab_(maker().fresh_copy()) {
    lab_.replace("instrument.toml", "rotation_deg = [0, 0, 0]", "rotation_deg = [1.5, -2.25, 3.5]");
    lab_.replace("instrument.toml", "offset_mm = [0, 0]", "offset_mm = [1.25, -0.5]");
  }
  static const LabMaker& maker() {
    static const LabMaker kMaker;
    return kMaker;
  }
  ToolRun run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin() + 2, {"--stage-deg", "20", "--arm-deg", "45"});
    return run_tool(arguments, lab_.folder());
  }
  static Pose pose() { return {20 * kRadPerDeg, 45 * kRadPerDeg}; }

  Lab lab_;
};

TEST_F(Export, PoniThereAndBackIsTheSameDetector) {
  ASSERT_EQ(run({"export", "instrument.toml", "-o", "out.poni"}).status, 0);
  lab_.write("like.toml", lab_.read("instrument.toml"));
  lab_.replace("like.toml", "rotation_deg = [1.5, -2.25, 3.5]", "rotation_deg = [0, 0, 0]");
  const ToolRun back = run({"export", "out.poni", "--instrument", "like.toml", "-o", "back.toml"});
  ASSERT_EQ(back.status, 0) << back.err;
  const Instrument a = read_instrument(lab_.path("instrument.toml")), b = read_instrument(lab_.path("back.toml"));
  for (const GeometryKey& key : geometry_keys())
    EXPECT_NEAR(b.geometry.*key.member, a.geometry.*key.member, 1e-14) << key.name;
  EXPECT_NE(lab_.read("back.toml").find("# input: out.poni sha256 "), std::string::npos);
  EXPECT_EQ(back.err, "");
}

TEST_F(Export, PoniOfOtherPixelsIsToldOf) {
  ASSERT_EQ(run({"export", "instrument.toml", "-o", "out.poni"}).status, 0);
  lab_.write("like.toml", std::regex_replace(lab_.read("instrument.toml"), std::regex("pitch_um = [^\n]*"),
                                             "pitch_um = [9.0, 9.0]"));
  const ToolRun back = run({"export", "out.poni", "--instrument", "like.toml", "-o", "back.toml"});
  ASSERT_EQ(back.status, 0) << back.err;
  EXPECT_NE(back.err.find("note: out.poni says pixels of "), std::string::npos) << back.err;
  EXPECT_NE(back.err.find("like.toml 9 um x 9 um"), std::string::npos) << back.err;
}

// Millimetres taken for metres, and the pose of another file.
TEST_F(Export, PoniOfAnotherPlaceIsToldOf) {
  ASSERT_EQ(run({"export", "instrument.toml", "-o", "out.poni"}).status, 0);
  const ToolRun elsewhere = run_tool({"export", "out.poni", "--instrument", "instrument.toml", "--stage-deg", "30",
                                      "--arm-deg", "75", "-o", "elsewhere.toml"},
                                     lab_.folder());
  ASSERT_EQ(elsewhere.status, 0) << elsewhere.err;
  EXPECT_NE(elsewhere.err.find("units, and this pose?"), std::string::npos) << elsewhere.err;
  lab_.write("far.poni", std::regex_replace(lab_.read("out.poni"), std::regex("Distance: [^\n]*"), "Distance: 325"));
  const ToolRun far = run({"export", "far.poni", "--instrument", "instrument.toml", "-o", "far.toml"});
  ASSERT_EQ(far.status, 0) << far.err;
  EXPECT_NE(far.err.find("note: far.poni puts the detector at 32"), std::string::npos) << far.err;
}

TEST_F(Export, CameramodelIsTheSameDetector) {
  const ToolRun done = run({"export", "instrument.toml", "-o", "out.cameramodel", "--json"});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_NE(done.out.find("out.cameramodel"), std::string::npos);
  const Instrument in = read_instrument(lab_.path("instrument.toml"));
  const SampleView view = sample_view(in, pose());
  const AngleMap lens = angle_map(view, load_lens_rays(lab_.path("out.cameramodel"), in.columns, in.rows));
  const AngleMap bare = angle_map(in, pose());
  for (std::size_t i = 0; i < bare.mask.size(); ++i) {
    ASSERT_EQ(bare.mask[i], 0);
    EXPECT_NEAR(lens.theta_s_rad[i], bare.theta_s_rad[i], 1e-12);
  }
}

TEST_F(Export, SaysWhatItCannotDo) {
  lab_.write("mirrored.toml", lab_.read("instrument.toml"));
  lab_.replace("mirrored.toml", "flip_rows = false", "flip_rows = true");
  ASSERT_EQ(run({"export", "instrument.toml", "-o", "some.poni"}).status, 0);
  const auto expect = [&](const std::vector<std::string>& arguments, const std::vector<std::string>& says) {
    const ToolRun r = run(arguments);
    EXPECT_EQ(r.status, 1);
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    for (const std::string& s : says) EXPECT_NE(r.err.find(s), std::string::npos) << s << " is not in: " << r.err;
    EXPECT_FALSE(fs::exists(lab_.path(arguments.back())));
  };
  expect({"export", "mirrored.toml", "-o", "out.cameramodel"}, {"mirrored.toml", "flip_rows", "mirror"});
  expect({"export", "some.poni", "-o", "out.toml"}, {"some.poni", "--instrument"});
  expect({"export", "some.poni", "--instrument", "instrument.toml", "-o", "out.cameramodel"}, {"out.cameramodel"});
  expect({"export", "instrument.toml", "-o", "out.toml"}, {"out.toml"});
  lab_.replace("some.poni", "Distance:", "Dist:");
  expect({"export", "some.poni", "--instrument", "instrument.toml", "-o", "out.toml"}, {"some.poni", "Distance"});
}

}  // namespace
}  // namespace scatmap::test
