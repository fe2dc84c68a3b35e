// Sets of targets that cannot determine a bench: each ends in a true statement. For benches drawn from the mechanical
// tolerances the reported directions hold what they promise, and what is missing is named, with a remedy that works.
// Does not prove anything about benches outside the tolerances.
#include <gtest/gtest.h>

#include "bench.h"
#include "calib/report.h"
#include "monte_carlo.h"
#include "scatmap/base/error.h"

namespace scatmap::calib::test {
namespace {

struct Degenerate {
  const char* name;
  std::vector<Command> commands;
  const char* says;  // part of some sentence about what is missing
  std::size_t mounts = 1;
};

std::vector<Command> grid(const std::vector<double>& stages, const std::vector<double>& arms,
                          const std::vector<double>& tilts, int beams) {
  std::vector<Command> out;
  for (const double s : stages) {
    for (const double a : arms) {
      for (const double t : tilts) out.push_back(mirror(s, a, t));
    }
  }
  for (int i = 0; i < beams; ++i) out.push_back(beam(179 + 2.0 * i / std::max(beams - 1, 1)));
  return out;
}

std::vector<Command> repeated(const Command& c, std::size_t times) { return std::vector<Command>(times, c); }

std::vector<Command> joined(std::vector<Command> a, const std::vector<Command>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::vector<Command> diagonal() {
  std::vector<Command> out;
  for (int i = -4; i <= 4; ++i) out.push_back(mirror(30, 0.25 * i, 0.1 * i));
  return out;
}

const std::vector<double> kStages{10, 20, 30, 40, 50, 60}, kArms{-1, 0, 1}, kTilts{-0.5, 0, 0.5};

std::vector<Degenerate> sets() {
  return {
      {"one mirror target", {mirror(20)}, "detector.distance_mm"},
      {"two mirror targets", {mirror(20), mirror(30)}, "add"},
      {"two targets side by side", {mirror(20, -1), mirror(20, 1)}, "add"},
      {"three targets", {mirror(20), mirror(30, 1), mirror(40, -1, 0.5)}, "add"},
      {"one direct beam", {beam(180)}, "stage.zero_deg"},
      {"three direct beams", {beam(179), beam(180), beam(181)}, "stage.zero_deg"},
      {"many direct beams", grid({}, {}, {}, 40), "mirror target"},
      {"one direct beam many times", repeated(beam(180), 40), "detector.distance_mm"},
      {"one mirror and one direct target", {mirror(20), beam(180)}, "detector.distance_mm"},
      // Tilted mirrors tell the stage from the arm; the beam's place remains.
      {"specular only", grid(kStages, kArms, kTilts, 0), "do not see beam.offset_mm.0"},
      {"one stage angle", grid({20}, kArms, kTilts, 3), "stage angles"},
      {"one stage angle, specular only", grid({20}, kArms, kTilts, 0), "direct-beam frame"},
      {"one arm angle, tilts only", grid({20}, {0}, {-0.5, -0.25, 0, 0.25, 0.5}, 0), "add"},
      {"all on the centre row", grid(kStages, kArms, {0}, 5), "detector.rotation_deg.0"},
      {"all on the centre row, specular only", grid(kStages, kArms, {0}, 0), "direct-beam frame"},
      {"spots in one place", grid(kStages, {0}, {0}, 0), "detector.distance_mm"},
      {"spots in one place and one direct beam", grid(kStages, {0}, {0}, 1), "detector.distance_mm"},
      {"spots on a diagonal", diagonal(), "add"},
      {"one pose a hundred times", repeated(mirror(20), 100), "detector.distance_mm"},
      {"two poses fifty times each", joined(repeated(mirror(20), 50), repeated(mirror(30, 1), 50)), "add"},
      {"stage angles within one degree", grid({20, 20.25, 20.5, 20.75, 21}, kArms, {0}, 3), "add"},
      {"four corners at one stage angle", grid({30}, {-1, 1}, {-0.5, 0.5}, 0), "add"},
      {"two mounts with one target each", {mirror(20, 0, 0, 0), mirror(30, 0, 0, 1)}, "detector.distance_mm", 2},
      {"small angles only", grid({5, 6, 7}, {0}, kTilts, 2), "add"},
  };
}

Lab lab_of(const Degenerate& d, std::mt19937_64& rng, const Noise& noise, const ParameterTable& table) {
  Lab lab = drawn_lab(rng, noise, 0, table);
  lab.commands = d.commands;
  std::normal_distribution<double> normal;
  for (std::size_t m = 1; m < d.mounts; ++m) lab.mounts.push_back({"second", 0.5 * normal(rng), 0.5 * normal(rng)});
  if (d.mounts > 1) lab.mounts[0].name = "first";
  return lab;
}

class DegenerateSets : public testing::TestWithParam<std::size_t> {};

TEST_P(DegenerateSets, EndInATrueStatement) {
  const Degenerate d = sets()[GetParam()];
  const Noise noise{0.05, 0.0005};
  const Instrument nominal = nominal_instrument(noise);
  const ParameterTable table(nominal, {"", {""}, {}}, {});
  std::mt19937_64 rng(341 + GetParam());
  constexpr int kTrials = 60;
  int outside = 0, silent = 0;
  double largest = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Lab lab = lab_of(d, rng, noise, table);
    const TargetList list = observe(lab, rng);
    const CalibrationResult r = calibrate(list, nominal, {});
    const std::string text = report_text(list, r);
    silent += text.find(d.says) == std::string::npos ? 1 : 0;
    EXPECT_FALSE(r.observability.blind.empty());
    for (const ParameterResult& p : r.parameters)
      EXPECT_TRUE(std::isfinite(p.value) && std::isfinite(p.sigma)) << p.name;
    if (d.mounts > 1) continue;  // the sample's own tilt and height are then unknown, and nothing is said about them
    bool all_inside = true;
    for (const DirectionSigma& s : r.directions) {
      const Eigen::Vector2d e = direction_error_px(lab, r.instrument, s.point);
      all_inside = all_inside && std::abs(e[0]) <= 3 * s.column_px && std::abs(e[1]) <= 3 * s.row_px;
      largest = std::max(largest, e.norm());
    }
    outside += all_inside ? 0 : 1;
  }
  EXPECT_LE(silent, kTrials / 20) << d.name;
  EXPECT_LE(outside, kTrials / 20) << d.name;
  std::printf("%-42s %d of %d benches with a direction outside three sigma, largest error %.1f px\n", d.name, outside,
              kTrials, largest);
}

INSTANTIATE_TEST_SUITE_P(All, DegenerateSets, testing::Range(std::size_t{0}, sets().size()));

TEST(Degenerate, ThereAreTwentySets) { EXPECT_GE(sets().size(), 20u); }

std::string all_sentences(const CalibrationResult& r) {
  std::string text;
  for (const BlindDirection& b : r.observability.blind) text += sentence(b) + "\n";
  return text;
}

// A direct beam does what the sentence says it does: untilted mirrors alone cannot tell the arm's zero from the
// stage's.
TEST(Degenerate, TheRemedyWorks) {
  const Noise noise{0.05, 0.0005};
  Lab lab{plain_bench(), {{"", 0, 0}}, grid(kStages, kArms, {0}, 0), noise.sigma_px};
  lab.bench.arm_encoder_sigma_deg = lab.bench.stage_encoder_sigma_deg = noise.encoder_deg;
  const Instrument nominal = nominal_instrument(noise);
  const CalibrationResult without = calibrate(observe_exactly(lab), nominal, {});
  lab.commands.push_back(beam(180));
  const CalibrationResult with = calibrate(observe_exactly(lab), nominal, {});
  EXPECT_LT(with.observability.blind.size(), without.observability.blind.size());
  EXPECT_NE(all_sentences(without).find("add one direct-beam frame"), std::string::npos) << all_sentences(without);
  EXPECT_EQ(all_sentences(with).find("add one direct-beam frame"), std::string::npos) << all_sentences(with);
}

// What no target sees, a bench can: with the mirror's own return known, the beam's place no longer rules directions.
TEST(Degenerate, AutocollimationIsNamedForTheBeamsPlaceAndWorks) {
  const Noise noise{0.05, 0.0005};
  Lab lab{plain_bench(), {{"", 0, 0}}, grid(kStages, kArms, kTilts, 4), noise.sigma_px};
  lab.bench.arm_encoder_sigma_deg = lab.bench.stage_encoder_sigma_deg = noise.encoder_deg;
  const Instrument nominal = nominal_instrument(noise);
  const TargetList list = observe_exactly(lab);
  const CalibrationResult without = calibrate(list, nominal, {});
  EXPECT_NE(all_sentences(without).find("--prior stage.zero_deg=0.002"), std::string::npos) << all_sentences(without);
  CalibrateOptions o;
  o.choices.prior_sigma["stage.zero_deg"] = 0.002;
  const CalibrationResult with = calibrate(list, nominal, o);
  EXPECT_GT(without.directions.front().rad, 5 * with.directions.front().rad);
}

// With everything else known the textbook gauge is exact: arm zero = 2 x stage zero.
TEST(Degenerate, ArmAndStageZeroAreOneGaugeWithoutDirectBeam) {
  const Lab lab{plain_bench(), {{"", 0, 0}}, grid(kStages, kArms, {0}, 0), 0.05};
  const Instrument nominal = believed(lab.bench);
  const TargetList list = observe_exactly(lab);
  CalibrateOptions o;
  o.select = false;
  const ParameterTable table(nominal, list, {});
  for (Eigen::Index i = 0; i < table.size(); ++i) {
    const std::string& name = table[i].name;
    if (name != "arm.zero_deg" && name != "stage.zero_deg" && name != "detector.distance_mm")
      o.choices.fix.push_back(name);
  }
  const CalibrationResult r = calibrate(list, nominal, o);
  ASSERT_EQ(r.observability.blind.size(), 1u);
  const std::string& names = r.observability.blind[0].parameters;
  EXPECT_NE(names.find("arm.zero_deg"), std::string::npos) << names;
  EXPECT_NE(names.find("stage.zero_deg"), std::string::npos) << names;
  EXPECT_LE(r.observability.blind[0].singular_value, 1e-6);
  EXPECT_EQ(r.observability.blind[0].remedy, "add one direct-beam frame (arm at 180 degrees)");
}

TEST(Degenerate, FreeWithoutPriorIsRefusedByName) {
  Lab lab{plain_bench(), {{"", 0, 0}}, grid(kStages, kArms, kTilts, 4), 0.05};
  const Instrument nominal = believed(lab.bench);
  CalibrateOptions o;
  o.choices.free = {"arm.zero_deg",         "detector.rotation_deg.1", "detector.rotation_deg.0",
                    "detector.offset_mm.0", "detector.distance_mm",    "detector.rotation_deg.2"};
  try {
    calibrate(observe_exactly(lab), nominal, o);
    FAIL() << "gave numbers for a gauge direction";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("arm.zero_deg"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("--fix"), std::string::npos) << e.what();
  }
}

TEST(Degenerate, NothingFreeIsFine) {
  Lab lab{plain_bench(), {{"", 0, 0}}, grid(kStages, kArms, kTilts, 4), 0.05};
  const Instrument nominal = believed(lab.bench);
  const TargetList list = observe_exactly(lab);
  CalibrateOptions o;
  const ParameterTable table(nominal, list, {});
  for (Eigen::Index i = 0; i < table.size(); ++i) o.choices.fix.push_back(table[i].name);
  const CalibrationResult r = calibrate(list, nominal, o);
  EXPECT_FALSE(r.instrument.calibration.has_value());
  for (const TargetResult& t : r.targets) EXPECT_LE(t.residual_px.norm(), 1e-9);
}

// Numbers without any sense end in an error or in finite numbers.
TEST(Degenerate, NonsenseEndsInAnErrorOrInNumbers) {
  std::mt19937_64 rng(399);
  const auto within = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng); };
  const Instrument nominal = nominal_instrument({0.05, 0.0005});
  int refused = 0;
  for (int trial = 0; trial < 200; ++trial) {
    TargetList list{"t.csv", {""}, {}};
    const int count = 1 + static_cast<int>(within(0, 12));
    for (int i = 0; i < count; ++i) {
      Target t;
      t.kind = within(0, 1) < 0.3 ? TargetKind::kDirect : TargetKind::kSpecular;
      t.stage_rad = within(-90, 90) * kRadPerDeg;
      t.arm_rad = (within(0, 1) < 0.5 ? 2 * t.stage_rad : std::numbers::pi) + within(-30, 30) * kRadPerDeg;
      t.column_px = std::pow(10, within(0, 6));
      t.row_px = -std::pow(10, within(0, 6));
      t.sigma_px = std::pow(10, within(-6, 3));
      list.targets.push_back(t);
    }
    try {
      const CalibrationResult r = calibrate(list, nominal);
      for (const ParameterResult& p : r.parameters) EXPECT_TRUE(std::isfinite(p.value) && std::isfinite(p.sigma));
      EXPECT_EQ(report_json(list, r).find("nan"), std::string::npos);
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()), "");
      ++refused;
    }
  }
  std::printf("%d of 200 refused\n", refused);
}

// Two halves that contradict each other, and centroids that somebody wrote down in thousands of pixels.
TEST(Degenerate, ContradictionsAndWrongUnitsAreRefused) {
  const Noise noise{0.05, 0.0005};
  const Instrument nominal = nominal_instrument(noise);
  std::mt19937_64 rng(402);
  Lab lab = drawn_lab(rng, noise, 0, ParameterTable(nominal, {"", {""}, {}}, {}));
  lab.commands = full_plan();
  const TargetList list = observe(lab, rng);
  TargetList halves = list, thousandths = list;
  for (Target t : list.targets) {
    t.column_px += 40;
    halves.targets.push_back(t);
  }
  for (Target& t : thousandths.targets) {
    t.column_px *= 1e-3;
    t.row_px *= 1e-3;
  }
  EXPECT_NO_THROW(calibrate(list, nominal));
  EXPECT_THROW(calibrate(halves, nominal), Error);
  EXPECT_THROW(calibrate(thousandths, nominal), Error);
}

}  // namespace
}  // namespace scatmap::calib::test
