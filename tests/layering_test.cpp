// Holds the #include lines of lib, calib, data-synthetic and tools to the edges between rooms (design, "Rooms"): what
// is included must be reachable from the including room. Does not prove that the link lists agree, nor that a room
// which declares another's functions by hand is found out.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {
namespace fs = std::filesystem;

using Rooms = std::set<std::string>;

const std::map<std::string, Rooms> kEdges{
    {"base", {}},
    {"frame", {"base"}},
    {"counts", {"base", "frame"}},
    {"angles", {"base"}},
    {"brdf", {"base", "counts", "angles"}},
    {"model", {"base"}},
    {"compare", {"base", "brdf", "angles", "model"}},
    {"report", {"base", "compare", "brdf", "angles"}},
    {"calib", {"base", "angles", "brdf", "model", "compare"}},
    {"data-synthetic", {"base"}},
    {"tools", {"base", "report", "calib", "data-synthetic"}},
};

void add_reachable(const std::string& room, Rooms& out) {
  if (!out.insert(room).second) return;
  for (const std::string& next : kEdges.at(room)) add_reachable(next, out);
}

Rooms reachable(const std::string& room) {
  Rooms out;
  add_reachable(room, out);
  return out;
}

struct Include {
  std::string file;  ///< relative to the project: "lib/scatmap/brdf/merge.cpp"
  int line = 0;
  std::string target;
  bool quoted = false;
};

/// "lib/scatmap/brdf/merge.h" and "scatmap/brdf/merge.h" are of room brdf; "calib/solve.h" of calib.
std::optional<std::string> room_of(const std::string& path) {
  static const std::regex kRoom(R"(^(?:(?:lib/)?scatmap/([a-z]+)|(calib|data-synthetic|tools))/[^.].*)");
  std::smatch found;
  if (!std::regex_match(path, found, kRoom)) return std::nullopt;
  const std::string room = found[1].matched ? found[1] : found[2];
  if (!kEdges.contains(room)) return std::nullopt;
  return room;
}

bool is_of(const std::string& target, const std::string& package) {
  return target.starts_with(package + "/") || target == package + ".h";
}

/// What is wrong with one include; empty: nothing.
std::string complaint(const Include& include) {
  const std::string where = include.file + ":" + std::to_string(include.line) + " includes " + include.target;
  const auto from = room_of(include.file);
  if (!from) return where + ", but the file is in no known room";
  if (is_of(include.target, "ceres") && *from != "calib") return where + ", but only calib may use Ceres";
  const auto to = room_of(include.target);
  if (!to) {
    const bool ours = include.quoted || include.target.starts_with("scatmap/") || include.target.starts_with("tests/");
    return ours ? where + ", which names no header of a known room" : "";
  }
  if (!reachable(*from).contains(*to)) return where + ", but " + *from + " may not use " + *to;
  return "";
}

std::vector<Include> includes_of(std::istream& text, const std::string& file) {
  static const std::regex kInclude(R"(^\s*#\s*include(?:_next)?\s*(.*?)\s*(?://.*|/\*.*)?$)");
  std::vector<Include> out;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    std::smatch found;
    if (!std::regex_match(line, found, kInclude)) continue;
    const std::string what = found[1];
    const bool quoted = !what.starts_with('<');
    out.push_back({file, number, what.size() > 2 ? what.substr(1, what.size() - 2) : what, quoted});
  }
  return out;
}

std::vector<std::string> complaints(const std::vector<Include>& includes) {
  std::vector<std::string> out;
  Rooms files_with_mrcal;
  for (const Include& i : includes) {
    if (const std::string wrong = complaint(i); !wrong.empty()) out.push_back(wrong);
    if (is_of(i.target, "mrcal")) files_with_mrcal.insert(i.file);
  }
  if (files_with_mrcal.size() > 1) {
    std::string wrong = "more than one file includes mrcal:";
    for (const std::string& f : files_with_mrcal) wrong += " " + f;
    out.push_back(wrong);
  }
  return out;
}

std::vector<Include> includes_of_project() {
  const fs::path root = SCATMAP_SOURCE_DIR;
  std::vector<Include> out;
  for (const char* folder : {"lib", "calib", "data-synthetic", "tools"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream text(entry.path());
      const auto found = includes_of(text, entry.path().lexically_relative(root).generic_string());
      EXPECT_FALSE(text.bad()) << entry.path();
      out.insert(out.end(), found.begin(), found.end());
    }
  }
  return out;
}

TEST(Layering, IncludesFollowTheEdges) {
  const std::vector<Include> includes = includes_of_project();
  Rooms seen;
  for (const Include& i : includes) seen.insert(room_of(i.file).value_or("?"));
  for (const char* room :
       {"base", "frame", "counts", "angles", "brdf", "model", "compare", "report", "data-synthetic", "tools"}) {
    EXPECT_TRUE(seen.contains(room)) << "no file of " << room << " was read";
  }
  for (const std::string& wrong : complaints(includes)) ADD_FAILURE() << wrong;
}

TEST(Layering, SourcesHaveTheExtensionsThatAreRead) {
  for (const char* folder : {"lib", "calib", "data-synthetic", "tools"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SCATMAP_SOURCE_DIR) / folder)) {
      const Rooms others{".c", ".cc", ".cxx", ".hh", ".hpp", ".hxx", ".inc", ".inl", ".ipp", ".tpp", ".ixx"};
      EXPECT_FALSE(others.contains(entry.path().extension().string())) << entry.path();
    }
  }
}

TEST(Layering, WhatMustNeverBeReachedIsNot) {
  EXPECT_FALSE(reachable("angles").contains("counts"));
  EXPECT_FALSE(reachable("counts").contains("angles"));
  EXPECT_FALSE(reachable("model").contains("angles"));
  EXPECT_EQ(reachable("data-synthetic"), (Rooms{"base", "data-synthetic"}));
  for (const char* room : {"base", "frame", "counts", "angles", "brdf", "model", "compare", "report"}) {
    EXPECT_FALSE(reachable(room).contains("calib")) << room;
    EXPECT_FALSE(reachable(room).contains("tools")) << room;
    EXPECT_FALSE(reachable(room).contains("data-synthetic")) << room;
  }
}

std::vector<std::string> judged(const std::string& file, const std::string& text) {
  std::istringstream lines(text);
  return complaints(includes_of(lines, file));
}

TEST(Layering, CheckerFindsWhatIsWrong) {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"lib/scatmap/angles/a.cpp", "#include \"scatmap/counts/dark.h\"\n"},
      {"lib/scatmap/counts/a.h", "  #  include \"scatmap/angles/geometry.h\"  // why not\n"},
      {"lib/scatmap/model/a.cpp", "#include <scatmap/angles/geometry.h>\n"},
      {"lib/scatmap/brdf/a.cpp", "#include \"scatmap/report/fits_file.h\"\n"},
      {"lib/scatmap/brdf/a.cpp", "#include \"calib/solve.h\"\n"},
      {"lib/scatmap/base/a.h", "#include \"scatmap/frame/frame.h\"\n"},
      {"lib/scatmap/report/a.h", "#include \"tools/verbs.h\"\n"},
      {"lib/scatmap/report/a.h", "#include \"tests/support/random_instrument.h\"\n"},
      {"lib/scatmap/report/a.h", "#include \"../brdf/merge.h\"\n"},
      {"lib/scatmap/report/a.h", "#include \"fits_file.h\"\n"},
      {"lib/scatmap/report/a.h", "#include HEADER\n"},
      {"lib/scatmap/util/a.h", "#include <cmath>\n"},
      {"lib/scatmap/compare/a.cpp", "#include <ceres/ceres.h>\n"},
      {"tools/a.cpp", "#include <ceres/ceres.h>\n"},
      {"data-synthetic/a.cpp", "#include \"scatmap/angles/geometry.h\"\n"},
      {"data-synthetic/a.cpp", "#include \"scatmap/brdf/merge.h\"\n"},
      {"calib/a.cpp", "#include \"data-synthetic/scene.h\"\n"},
      {"calib/a.cpp", "#include \"scatmap/report/picture.h\"\n"},
  };
  for (const auto& [file, text] : wrong) EXPECT_EQ(judged(file, text).size(), 1U) << file << ": " << text;
  const Include first{"calib/a.cpp", 1, "mrcal/mrcal.h", false}, second{"tools/b.cpp", 1, "mrcal.h", false};
  EXPECT_EQ(complaints({first, first}).size(), 0U);
  EXPECT_EQ(complaints({first, second}).size(), 1U);
}

TEST(Layering, CheckerLeavesGoodLinesAlone) {
  EXPECT_TRUE(judged("calib/a.cpp", "#include <ceres/ceres.h>\n#include \"scatmap/frame/frame.h\"\n").empty());
  EXPECT_TRUE(judged("tools/a.cpp", "#include \"scatmap/model/model.h\"\n#include \"calib/solve.h\"\n").empty());
  EXPECT_TRUE(judged("data-synthetic/a.cpp", "#include \"scatmap/base/units.h\"\n#include <fitsio.h>\n").empty());
  EXPECT_TRUE(judged("lib/scatmap/angles/a.h", "// #include \"scatmap/counts/dark.h\"\n#include <vector>\n").empty());
}

}  // namespace
