// scatmap chart: one job runs, its files appear and its table parses; bad usage is refused. Does not prove any figure.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/run_tool.h"

namespace scatmap::test {
namespace {
namespace fs = std::filesystem;

class ChartVerb : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / "chart";
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "tmp");
  }
  fs::path folder_;
};

// Fields of one line of CSV; quotes hold commas.
std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> out(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      out.emplace_back();
    else
      out.back() += c;
  }
  return out;
}

TEST_F(ChartVerb, OneJobWritesItsTableAndPictures) {
  const ToolRun run = run_tool({"chart", "inverse", "-o", "out", "--seconds", "0.01"}, folder_);
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("ns per direction"), std::string::npos);
  for (const char* const name : {"inverse.svg", "inverse.png"}) EXPECT_GT(fs::file_size(folder_ / "out" / name), 1000u);
  std::ifstream csv(folder_ / "out" / "charts.csv");
  std::string line;
  ASSERT_TRUE(std::getline(csv, line));
  const std::vector<std::string> header = fields(line);
  EXPECT_EQ(header.front(), "job");
  int rows = 0;
  while (std::getline(csv, line)) {
    const std::vector<std::string> row = fields(line);
    ASSERT_EQ(row.size(), header.size()) << line;
    EXPECT_EQ(row[0], "inverse");
    EXPECT_GT(std::stod(row[5]), 0) << line;  // ns_min
    EXPECT_GE(std::stod(row[8]), 0) << line;  // largest_error
    if (!row[12].empty()) {
      EXPECT_LE(std::stod(row[8]), std::stod(row[12])) << line;  // bound
    }
    ++rows;
  }
  EXPECT_GE(rows, 2);
}

std::string whole(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST_F(ChartVerb, TheManualQuotesTheBoundsOfTheHeaders) {
  ASSERT_EQ(run_tool({"chart", "bounds", "-o", "out"}, folder_).status, 0);
  const std::string table = whole(folder_ / "out" / "bounds.md");
  EXPECT_GT(table.size(), 1000u);
  EXPECT_NE(whole(SCATMAP_SOURCE_DIR "/docs/methods.md").find(table), std::string::npos)
      << "docs/methods.md: paste the table of `scatmap chart bounds`";
}

TEST_F(ChartVerb, BoundsAreInTheJsonAndTheEmptyTableHasItsHeader) {
  const ToolRun run = run_tool({"chart", "bounds", "--json", "-o", "out"}, folder_);
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json all = nlohmann::json::parse(run.out);
  EXPECT_GE(all.at("bounds").size(), 15u);
  for (const auto& row : all.at("bounds")) EXPECT_GT(row.at("bound").get<double>(), 0) << row;
  EXPECT_EQ(whole(folder_ / "out" / "charts.csv").substr(0, 11), "job,method,");
}

TEST_F(ChartVerb, BadJobsAndExistingFolders) {
  const ToolRun unknown = run_tool({"chart", "nonsense", "-o", "out"}, folder_);
  EXPECT_EQ(unknown.status, 2);
  EXPECT_FALSE(fs::exists(folder_ / "out"));
  fs::create_directories(folder_ / "out");
  std::ofstream(folder_ / "out" / "kept") << "mine";
  EXPECT_EQ(run_tool({"chart", "inverse", "-o", "out", "--seconds", "0.01"}, folder_).status, 1);
  EXPECT_TRUE(fs::exists(folder_ / "out" / "kept"));
}

}  // namespace
}  // namespace scatmap::test
