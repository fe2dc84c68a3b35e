// How gnuplot is run: whole files or none, its own words in errors, names that cannot reach a shell or a pipe.
// What the pictures show is tested in picture_test.cpp.
#include "scatmap/report/gnuplot.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "scatmap/base/error.h"

namespace scatmap {
namespace {

namespace fs = std::filesystem;

class Gnuplot : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("gnuplot_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "out");
    fs::create_directories(folder_ / "tmp");
    setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
  }
  void TearDown() override {
    EXPECT_TRUE(fs::is_empty(folder_ / "tmp")) << "the private folder is gone whatever happened";
    unsetenv("TMPDIR");
    fs::remove_all(folder_);
  }
  fs::path out(const std::string& name) const { return folder_ / "out" / name; }
  bool nothing_written() const { return fs::is_empty(folder_ / "out"); }
  static std::string problem(const Plot& plot, const fs::path& target, const PictureOptions& options = {}) {
    try {
      write_picture(plot, target, options);
    } catch (const Error& e) {
      return e.what();
    }
    return {};
  }
  fs::path folder_;
};

const Plot kGood{
    .script = "plot data using 1:2 with lines notitle", .data = "0 0\n1 1\n", .width_px = 300, .height_px = 200};

TEST_F(Gnuplot, PngAndSvgBeginAsTheyMust) {
  write_picture(kGood, out("a.png"));
  EXPECT_EQ(read_text_file(out("a.png")).substr(0, 8), "\x89PNG\r\n\x1a\n");
  write_picture(kGood, out("a.svg"));
  const std::string svg = read_text_file(out("a.svg"));
  EXPECT_NE(svg.find("<svg"), std::string::npos);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
}

TEST_F(Gnuplot, FailureGivesItsWordsAndLeavesNothing) {
  const Plot bad{.script = "set title 'fine'\nplot nonsense(", .data = ""};
  const std::string said = problem(bad, out("a.png"), {.overwrite = Overwrite::kKeep, .keep_script = true});
  EXPECT_NE(said.find("gnuplot failed: line "), std::string::npos) << said;
  EXPECT_EQ(said.find('\n'), std::string::npos);
  EXPECT_TRUE(nothing_written());
  // A script that runs but draws nothing is a failure too.
  EXPECT_FALSE(problem(Plot{.script = "x = 1", .data = ""}, out("a.png")).empty());
  EXPECT_TRUE(nothing_written());
}

TEST_F(Gnuplot, MissingProgramNamesItsPackage) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder_.c_str(), 1);
  const std::string said = problem(kGood, out("a.png"));
  setenv("PATH", path.c_str(), 1);
  EXPECT_NE(said.find("gnuplot-nox"), std::string::npos) << said;
  EXPECT_TRUE(nothing_written());
}

TEST_F(Gnuplot, ExistingPictureIsKeptUnlessForced) {
  write_text_file(out("a.png"), "mine", Overwrite::kKeep);
  EXPECT_NE(problem(kGood, out("a.png")).find("--force"), std::string::npos);
  EXPECT_EQ(read_text_file(out("a.png")), "mine");
  EXPECT_FALSE(
      problem(Plot{.script = "plot nonsense(", .data = ""}, out("a.png"), {.overwrite = Overwrite::kForce}).empty());
  EXPECT_EQ(read_text_file(out("a.png")), "mine") << "a failure keeps the old file";
  write_picture(kGood, out("a.png"), {.overwrite = Overwrite::kForce});
  EXPECT_NE(read_text_file(out("a.png")), "mine");
}

TEST_F(Gnuplot, KeptScriptMakesThePictureAgain) {
  write_picture(kGood, out("a.png"), {.overwrite = Overwrite::kKeep, .keep_script = true});
  const std::string first = read_text_file(out("a.png"));
  fs::remove(out("a.png"));
  ASSERT_EQ(std::system(("cd '" + (folder_ / "out").string() + "' && gnuplot -d a.gp").c_str()), 0);
  EXPECT_EQ(read_text_file(out("a.png")), first);
}

TEST_F(Gnuplot, HostileNamesAreOnlyNames) {
  for (const std::string name :
       {"|touch hit.png", "< touch hit.png", "it's `touch hit` $(touch hit) \"x\" @y.png", "-.png", "#a;b.png"}) {
    write_picture(kGood, out(name), {.overwrite = Overwrite::kKeep, .keep_script = true});
    EXPECT_TRUE(fs::exists(out(name))) << name;
  }
  EXPECT_FALSE(fs::exists(out("hit")));
  EXPECT_FALSE(fs::exists(out("hit.png")));
  EXPECT_NE(problem(kGood, out("a\nb.png")).find("control characters"), std::string::npos);
}

TEST_F(Gnuplot, OtherExtensionsAreRefused) {
  for (const char* name : {"a.jpg", "a", "a.PNG"}) {
    EXPECT_NE(problem(kGood, out(name)).find(".png or .svg"), std::string::npos) << name;
  }
  EXPECT_TRUE(nothing_written());
}

TEST_F(Gnuplot, TextIsQuotedSoThatNothingIsReplaced) {
  EXPECT_EQ(gnuplot_text("a\nb\x7f"), "\"a b \"");
  for (const char* text : {"' . system('touch hit') . ' `touch hit` \\", "''", "", "a''", "it's", "'a'",
                           "@data '@data' \"@data\"", "#hit $hit {hit} \"hit\" θ\\n 100%"}) {
    // Printed by gnuplot and read back by cat: the text came through unchanged.
    const Plot plot{.script = "set print './seen'\nprint " + gnuplot_text(text) + "\nunset print\nset title " +
                              gnuplot_text(text) + " noenhanced\nseen = system('cat seen')\nif (seen ne " +
                              gnuplot_text(text) + ") { exit status 3 }\nplot x",
                    .data = ""};
    EXPECT_EQ(problem(plot, out("a.png"), {.overwrite = Overwrite::kForce, .keep_script = false}), "") << text;
    EXPECT_FALSE(fs::exists(out("hit")) || fs::exists("hit")) << text;
  }
}

}  // namespace
}  // namespace scatmap
