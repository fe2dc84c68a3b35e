// The verb uncertainty: its answers agree with the map they are about and with each other, and an interval that reaches
// zero has no decibels. Does not prove the uncertainties themselves (tests/flow, tests/brdf).
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>

#include "cli/lab.h"
#include "scatmap/report/map_fits.h"

namespace scatmap::test {
namespace {

class UncertaintyVerb : public testing::Test {
 protected:
  UncertaintyVerb() : lab_(maker().fresh_copy()), map_(read_map_fits(lab_.path("maps/measured.fits"))) {}
  static const LabMaker& maker() {
    static const LabMaker kMaker;
    return kMaker;
  }
  ToolRun run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"uncertainty", "maps/measured.fits"});
    return run_tool(arguments, lab_.folder());
  }
  nlohmann::json json(std::vector<std::string> arguments) const {
    arguments.emplace_back("--json");
    const ToolRun done = run(arguments);
    if (done.status != 0) throw std::runtime_error(done.err);
    return nlohmann::json::parse(done.out);
  }
  // The map again, of next to no light.
  void dim() {
    lab_.replace("scene.toml", "exposure_s = 0.25", "exposure_s = 0.0001");
    ASSERT_EQ(run_tool({"simulate", "scene.toml", "-o", "dim"}, lab_.folder()).status, 0);
    ASSERT_EQ(run_tool({"brdf", "dim/measurement.toml", "-o", "maps/measured.fits", "--force"}, lab_.folder()).status,
              0);
    map_ = read_map_fits(lab_.path("maps/measured.fits"));
  }
  std::pair<int, int> brightest() const {
    return first_by([](double a, double b) { return a > b; });
  }
  std::pair<int, int> faintest() const {
    return first_by([](double a, double b) { return a != 0 && std::abs(a) < std::abs(b); });
  }
  /// Column and row of the good pixel that comes before all others.
  template <class Before>
  std::pair<int, int> first_by(Before before) const {
    std::pair<int, int> at{-1, -1};
    for (int r = 0; r < map_.brdf_per_sr.rows(); ++r) {
      for (int c = 0; c < map_.brdf_per_sr.columns(); ++c) {
        if (map_.mask(r, c) == 0 && (at.first < 0 || before(value(c, r), value(at.first, at.second)))) at = {c, r};
      }
    }
    return at;
  }
  double value(int column, int row) const { return map_.brdf_per_sr(row, column); }

  Lab lab_;
  BrdfMap map_;
};

std::string text_of(std::pair<int, int> pixel) {
  return std::to_string(pixel.first) + "," + std::to_string(pixel.second);
}

TEST_F(UncertaintyVerb, BudgetAddsUpToTheTotal) {
  const auto peak = brightest();
  const nlohmann::json all = json({"--pixel", text_of(peak)});
  const double f = all.at("value"), u = all.at("u");
  EXPECT_EQ(static_cast<float>(f), static_cast<float>(value(peak.first, peak.second)));
  double squares = 0, shares = 0;
  for (const auto& line : all.at("budget")) {
    squares += std::pow(line.at("contribution").get<double>(), 2);
    shares += line.at("share").get<double>();
  }
  EXPECT_NEAR(std::sqrt(squares) * f / u, 1, 1e-9);
  EXPECT_NEAR(shares, 1, 1e-9);
  EXPECT_NEAR(all.at("expanded_k2").get<double>() / u, 2, 1e-12);
  const auto interval = all.at("monte_carlo").at("symmetric_95");
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(interval.at("db").at(k).get<double>(), 10 * std::log10(interval.at("factors").at(k).get<double>()),
                1e-9);
}

TEST_F(UncertaintyVerb, RegionOfOnePixelIsThePixel) {
  const std::string peak = text_of(brightest());
  const nlohmann::json pixel = json({"--pixel", peak}), region = json({"--region", peak + "," + peak});
  EXPECT_EQ(pixel, region);
}

TEST_F(UncertaintyVerb, ARatioToWhatMayBeNothingIsToldOf) {
  const std::string note = "note: the second value may be 0", peak = text_of(brightest());
  EXPECT_EQ(run({"--pixel", peak, "--and", peak}).err.find(note), std::string::npos);
  dim();
  EXPECT_NE(run({"--pixel", peak, "--and", text_of(faintest())}).err.find(note), std::string::npos);
}

TEST_F(UncertaintyVerb, AnIntervalThatReachesZeroHasNoDecibels) {
  dim();
  const std::string faint = text_of(faintest());
  const ToolRun done = run({"--pixel", faint});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_NE(done.out.find("(reaches 0 or below: no dB)"), std::string::npos) << done.out;
  EXPECT_FALSE(std::regex_search(done.out, std::regex("\\b(nan|inf)\\b"))) << done.out;
  const nlohmann::json all = json({"--pixel", faint});
  const auto interval = all.at("first_order").at("symmetric_95");
  EXPECT_LT(interval.at("factors").at(0).get<double>(), 0);
  EXPECT_TRUE(interval.at("db").at(0).is_null()) << interval;
}

// With the filters that it names calibrated to the uncertainty that it asks for, the budget reaches the target.
TEST_F(UncertaintyVerb, TheCalibrationAskedForBringsTheTotal) {
  constexpr double kTarget = 0.1, kLn10 = 2.302585092994046;
  const nlohmann::json all = json({"--pixel", text_of(brightest()), "--target-percent", "10"});
  std::size_t reachable = 0;
  for (const auto& wish : all.at("filter_targets")) {
    const std::vector<std::string> names = wish.at("filters");
    const auto calibrated = [&](const std::string& cause) {
      return std::any_of(names.begin(), names.end(), [&](const std::string& n) { return cause == n; });
    };
    double squares = 0;
    for (const auto& line : all.at("budget")) {
      if (!calibrated(line.at("cause"))) squares += std::pow(line.at("contribution").get<double>(), 2);
    }
    if (wish.at("u_od").is_null()) {
      EXPECT_GE(std::sqrt(squares), kTarget) << wish;
      continue;
    }
    ++reachable;
    squares += static_cast<double>(names.size()) * std::pow(kLn10 * wish.at("u_od").get<double>(), 2);
    EXPECT_NEAR(std::sqrt(squares), kTarget, 1e-4 * kTarget) << wish;
  }
  EXPECT_GE(reachable, 1u);
}

}  // namespace
}  // namespace scatmap::test
