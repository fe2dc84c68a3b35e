// The matrix of `chart stability`: no cell empty, none fails, and what holds is within the bound it names. The cells
// carry their own truths (tools/chart/stability_*.cpp). Does not prove anything about regimes that are not listed.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace {

nlohmann::json matrix() {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "stability";
  const std::string json = folder.string() + ".json";
  const std::string command = std::string(SCATMAP_TOOL) + " chart stability --force --json -o '" + folder.string() +
                              "' > '" + json + "' 2> /dev/null";
  if (std::system(command.c_str()) != 0) return {};
  std::ifstream in(json);
  return nlohmann::json::parse(in).at("stability");
}

TEST(Stability, EveryMethodInEveryRegimeAndNoneFails) {
  const nlohmann::json cells = matrix();
  std::map<std::string, std::set<std::string>> regimes, methods;
  std::map<std::string, std::size_t> count, holding;
  for (const auto& cell : cells) {
    const std::string job = cell.at("job"), verdict = cell.at("verdict"), reason = cell.at("reason");
    const std::string what =
        job + ", " + cell.at("regime").get<std::string>() + ", " + cell.at("method").get<std::string>();
    regimes[job].insert(cell.at("regime"));
    methods[job].insert(cell.at("method"));
    ++count[job];
    EXPECT_NE(verdict, "FAILS") << what << ": " << reason;
    if (verdict == "refuses" || verdict == "falls back") {
      EXPECT_NE(reason, "") << what;
    } else {
      ASSERT_TRUE(cell.at("worst_error").is_number()) << what;
    }
    if (job != "inverse" && verdict != "refuses" && reason.find("amplification") == std::string::npos) {
      EXPECT_TRUE(cell.at("amplification_sigma").is_number()) << what << ": neither an amplification nor a reason";
    }
    if (verdict != "holds") continue;
    ++holding[job];
    EXPECT_LE(cell.at("worst_error").get<double>(), cell.at("bound").get<double>()) << what;
  }
  const std::map<std::string, std::size_t> least{{"angles", 29}, {"inverse", 29},     {"lens", 26},  {"model", 35},
                                                 {"brdf", 22},   {"uncertainty", 11}, {"spots", 60}, {"calibrate", 19}};
  for (const auto& [job, number] : least) {
    EXPECT_GE(regimes[job].size(), number) << job;
    EXPECT_EQ(count[job], regimes[job].size() * methods[job].size()) << job << ": cells are missing";
    EXPECT_GE(2 * holding[job], count[job]) << job << ": most regimes are no reason to refuse";
  }
}

}  // namespace
