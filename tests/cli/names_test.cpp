// Odd but legal file names are plain files to every verb: whatever the shell, CFITSIO's extended file names, TOML or
// HISTORY cards might make of them, the output appears under exactly the name asked for and nothing else is touched.
// Does not prove it for every name, nor that other programs can open such files.
#include <sstream>

#include "cli/bad_calibrations.h"

namespace scatmap::test {
namespace {

const std::string kNotUtf8 = "\xff\xfe not UTF-8";

const std::vector<std::string> kNames{"with space",
                                      " leading blank",
                                      "trailing blank ",
                                      "brackets[1:9,2:8]",
                                      "ext[BRDF]",
                                      "parens(out)",
                                      "-dash",
                                      "--force",
                                      "+1",
                                      "!clobber",
                                      "~tilde",
                                      "$HOME",
                                      "*star?",
                                      "quote'\"",
                                      "back\\slash",
                                      "semi;colon",
                                      "per%cent%s",
                                      "hash#",
                                      "mem:",
                                      "http:x",
                                      "two.dots.",
                                      "gr\u00fc\u00dfe-\u6e2c\u5b9a",
                                      "line\nbreak",
                                      "tab\there",
                                      kNotUtf8};

std::string toml_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (c == '\n') out += "\\n";
    if (c == '\t') out += "\\t";
    if (c != '\n' && c != '\t') out += c;
  }
  return out;
}

void expect_only(const Lab& lab, const std::vector<std::string>& command, const std::string& output) {
  const auto before = lab.contents();
  const ToolRun run = run_tool(command, lab.folder());
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run.err, "");
  EXPECT_EQ(changes(before, lab.contents()), std::vector<std::string>{"wrote " + output});
}

// The list of targets must be readable again, whatever its own and its frames' names.
void expect_refers_to(const Lab& lab, const std::string& csv, std::size_t targets) {
  std::istringstream lines(lab.read(csv));
  std::size_t data = 0;
  for (std::string line; std::getline(lines, line);) data += !line.empty() && line.front() != '#';
  EXPECT_EQ(data, targets + 1) << lab.read(csv);
}

class Names : public testing::Test {
 protected:
  LabMaker maker_;
};

TEST_F(Names, OfInputAndOutput) {
  for (const std::string& name : kNames) {
    SCOPED_TRACE(name);
    const Lab lab = maker_.fresh_copy();
    fs::copy_file(lab.path("instrument.toml"), lab.path(name));
    expect_only(lab, {"angles", "--output=" + name + ".fits", "--stage-deg=20", "--arm-deg=40", "--", name},
                name + ".fits");
    expect_only(lab, {"angles", "--output=" + name + ".exr", "--stage-deg=20", "--arm-deg=40", "--", name},
                name + ".exr");
  }
}

TEST_F(Names, OfMaps) {
  for (const std::string& name : kNames) {
    SCOPED_TRACE(name);
    const Lab lab = maker_.fresh_copy();
    fs::rename(lab.path("maps/measured.fits"), lab.path(name));
    expect_only(lab, {"model", "--like=" + name, "--output=out.fits", "model.toml"}, "out.fits");
  }
}

TEST_F(Names, OfFrames) {
  for (const std::string& name : kNames) {
    if (name == kNotUtf8) continue;  // TOML is UTF-8: such a frame cannot be named in it
    SCOPED_TRACE(name);
    Lab lab = maker_.fresh_copy();
    fs::rename(lab.path("frames/exposure1_001.fits"), lab.path(name));
    lab.replace("measurement.toml", "frames/exposure1_001.fits", toml_text(name));
    expect_only(lab, {"brdf", "measurement.toml", "--output=out.fits"}, "out.fits");
  }
}

TEST_F(Names, OfFolders) {
  for (const std::string& name : kNames) {
    SCOPED_TRACE(name);
    const Lab lab = maker_.fresh_copy();
    const auto before = lab.contents();
    const ToolRun run = run_tool({"simulate", "--output=" + name, "scene.toml"}, lab.folder());
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_TRUE(fs::is_directory(lab.path(name)));
    for (const std::string& change : changes(before, lab.contents())) {
      EXPECT_TRUE(change.starts_with("wrote " + name)) << change;
    }
    const ToolRun again =
        run_tool({"brdf", "--output=out.fits", "--json", "--", name + "/measurement.toml"}, lab.folder());
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_TRUE(fs::is_regular_file(lab.path("out.fits")));
  }
}

TEST_F(Names, OfTargetsSpotsAndCalibrations) {
  for (const std::string& name : kNames) {
    SCOPED_TRACE(name);
    const Lab lab = maker_.fresh_copy();
    lab.write(name, kTargets);
    expect_only(lab, {"calibrate", "--instrument=instrument.toml", "--output=" + name + ".toml", "--", name},
                name + ".toml");
    const ToolRun again =
        run_tool({"angles", "--output=out.fits", "--stage-deg=20", "--arm-deg=40", "--", name + ".toml"}, lab.folder());
    EXPECT_EQ(again.status, 0) << again.err;
    const bool in_csv = name.find_first_of(",\"\n\r") == std::string::npos;
    const std::string frame = in_csv ? name + ".frame" : "frame";
    fs::copy_file(lab.path("frames/signature_001.fits"), lab.path(frame));
    expect_only(lab,
                {"spots", "--instrument=instrument.toml", "--kind=direct", "--stage-deg=0", "--arm-deg=180",
                 "--tilt-deg=0", "--output=" + name + ".csv", "--", frame},
                name + ".csv");
    expect_refers_to(lab, name + ".csv", 1);
  }
}

TEST_F(Names, OfMapsThatAreAskedOrCompared) {
  for (const std::string& name : kNames) {
    SCOPED_TRACE(name);
    const Lab lab = maker_.fresh_copy();
    fs::copy_file(lab.path("maps/measured.fits"), lab.path(name));
    for (const std::string form : {"--json", "--target-percent=5"}) {
      const ToolRun asked = run_tool({"uncertainty", "--pixel=20,30", form, "--", name}, lab.folder());
      EXPECT_EQ(asked.status, 0) << asked.err;
    }
    const ToolRun compared =
        run_tool({"compare", "--output=" + name + ".d", "--pictures=none", "--json", "--", name, "maps/modelled.fits"},
                 lab.folder());
    EXPECT_EQ(compared.status, 0) << compared.err;
    EXPECT_TRUE(fs::is_regular_file(lab.path(name + ".d/comparison.json")));
    const ToolRun spots =
        run_tool({"spots", "--instrument=instrument.toml", "--kind=direct", "--stage-deg=0", "--arm-deg=180", "--json",
                  "--output=" + name + ".csv", "frames/signature_001.fits"},
                 lab.folder());
    EXPECT_EQ(spots.status, 0) << spots.err;
  }
}

TEST_F(Names, DashAndBytesThatAreNotUtf8) {
  const Lab lab = maker_.fresh_copy();
  fs::copy_file(lab.path("measurement.toml"), lab.path("-dash.toml"));
  EXPECT_EQ(run_tool({"brdf", "-o", "out.fits", "--", "-dash.toml"}, lab.folder()).status, 0);
  EXPECT_TRUE(fs::is_regular_file(lab.path("out.fits")));
  EXPECT_EQ(run_tool({"simulate", "scene.toml", "-o", kNotUtf8}, lab.folder()).status, 0);
  const ToolRun brdf = run_tool({"brdf", kNotUtf8 + "/measurement.toml", "-o", "out2.fits", "--json"}, lab.folder());
  EXPECT_EQ(brdf.status, 0) << brdf.err;
  const ToolRun json = run_tool({"simulate", "scene.toml", "--json", "-o", "2" + kNotUtf8}, lab.folder());
  EXPECT_EQ(json.status, 0) << json.err;
}

TEST_F(Names, StayOneLineInMessages) {
  for (const std::string& name : kNames) {
    SCOPED_TRACE(name);
    const Lab lab = maker_.fresh_copy();
    const auto before = lab.contents();
    const ToolRun run = run_tool({"brdf", "--output=out.fits", "--json", "--", name}, lab.folder());
    EXPECT_EQ(run.status, 1);
    EXPECT_TRUE(is_one_message(run.err)) << run.err;
    EXPECT_EQ(changes(before, lab.contents()), std::vector<std::string>{});
  }
}

}  // namespace
}  // namespace scatmap::test
