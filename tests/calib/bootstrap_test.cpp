// Bootstrap: with stated noise its scatter is the covariance of the solution; with noise that is not as stated,
// residuals and cases find the true one. Does not prove coverage (tests/calib/monte_carlo_test.cpp).
#include "calib/bootstrap.h"

#include <gtest/gtest.h>

#include "bench.h"
#include "scatmap/base/error.h"

namespace scatmap::calib::test {
namespace {

// As many direct beams as mirrors, so that each half alone is many.
std::vector<Command> alternating_plan(std::mt19937_64& rng) {
  std::vector<Command> out;
  const auto within = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng); };
  for (int i = 0; i < 150; ++i) {
    out.push_back(beam(180 + within(-1, 1)));
    out.push_back(mirror(within(10, 60), within(-1, 1), within(-0.5, 0.5)));
  }
  return out;
}

struct Session {
  TargetList list;
  CalibrationResult result;
};

// What is not seen is held, so that only the noise of targets decides.
CalibrateOptions what_targets_see() {
  CalibrateOptions o;
  o.select = false;
  o.choices.fix = {"beam.offset_mm.0",     "beam.offset_mm.1",        "beam.elevation_deg",     "arm.axis_offset_mm.0",
                   "arm.axis_offset_mm.1", "arm.axis_tilt_deg.0",     "arm.axis_tilt_deg.1",    "sample.height_mm",
                   "arm.zero_deg",         "detector.rotation_deg.0", "detector.rotation_deg.1"};
  o.choices.free = {"detector.distance_mm",    "detector.offset_mm.0", "detector.offset_mm.1",
                    "detector.rotation_deg.2", "stage.zero_deg",       "sample.tilt_deg"};
  return o;
}

Session session(double stated_share, const CalibrateOptions& options) {
  std::mt19937_64 rng(2024);
  Lab lab{plain_bench(), {{"", 0, 0}}, alternating_plan(rng), 0.1};
  lab.bench.arm_encoder_sigma_deg = lab.bench.stage_encoder_sigma_deg = 0.0005;
  Session out{observe(lab, rng), {}};
  lab.bench.arm_encoder_sigma_deg *= stated_share;
  lab.bench.stage_encoder_sigma_deg *= stated_share;
  for (Target& t : out.list.targets) t.sigma_px *= stated_share;
  out.result = calibrate(out.list, believed(lab.bench), options);
  return out;
}

constexpr int kTrials = 2000;
constexpr double kThreeErrors = 3 * 0.0158;  // 1/sqrt(2 trials)

void expect_ratio(const Bootstrap& b, const CalibrationResult& linear, double ratio, double tolerance) {
  ASSERT_EQ(b.directions.size(), linear.directions.size());
  EXPECT_EQ(b.failed, 0);
  for (std::size_t k = 0; k < b.directions.size(); ++k) {
    const std::string what = b.directions[k].point.where;
    EXPECT_NEAR(b.directions[k].column_px / linear.directions[k].column_px, ratio, tolerance * ratio) << what;
    EXPECT_NEAR(b.directions[k].row_px / linear.directions[k].row_px, ratio, tolerance * ratio) << what;
    EXPECT_NEAR(b.directions[k].rad / linear.directions[k].rad, ratio, tolerance * ratio) << what;
  }
}

TEST(Bootstrap, ParametricScatterIsTheCovariance) {
  const Session r = session(1, what_targets_see());
  const Bootstrap b = bootstrap(r.list, r.result, {BootstrapKind::kParametric, kTrials, 5});
  expect_ratio(b, r.result, 1, kThreeErrors);
  for (std::size_t k = 0; k < r.result.set.size(); ++k) {
    const double linear = r.result.parameters[static_cast<std::size_t>(r.result.set[k].index)].sigma;
    EXPECT_NEAR(b.parameter_sigma[k] / linear, 1, kThreeErrors);
  }
}

// Everything in the fit, most of it held by priors, which are drawn anew like the targets. With a tenth of the usual
// tolerances, where the linearisation holds; with all of them second-order terms come up in small components: rows at
// the centre are 1.7 times the covariance's on this bench, whose covariance there is 0.2 px against 40 px in columns.
TEST(Bootstrap, PriorsAreDrawnAnew) {
  CalibrateOptions all;
  all.select = false;
  const ParameterTable table(believed(plain_bench()), {"", {""}, {}}, {});
  for (Eigen::Index i = 0; i < table.size(); ++i) {
    if (table[i].role != Role::kHeld)
      all.choices.prior_sigma[table[i].name] = 0.1 * table[i].prior_sigma / table[i].unit;
  }
  const Session r = session(1, all);
  expect_ratio(bootstrap(r.list, r.result, {BootstrapKind::kParametric, kTrials, 6}), r.result, 1, kThreeErrors + 0.02);
}

TEST(Bootstrap, ResidualsAndCasesFindNoiseThatWasUnderstated) {
  const Session r = session(0.5, what_targets_see());
  expect_ratio(bootstrap(r.list, r.result, {BootstrapKind::kParametric, kTrials, 7}), r.result, 1, kThreeErrors);
  // 150 mirrors and 150 direct beams know their own noise to a seventeenth each.
  expect_ratio(bootstrap(r.list, r.result, {BootstrapKind::kResiduals, kTrials, 7}), r.result, 2, kThreeErrors + 0.15);
  expect_ratio(bootstrap(r.list, r.result, {BootstrapKind::kCases, kTrials, 7}), r.result, 2, kThreeErrors + 0.18);
}

TEST(Bootstrap, SeedDecidesAndNothingElse) {
  const Session r = session(1, what_targets_see());
  const auto sigma = [&](std::uint64_t seed) {
    return bootstrap(r.list, r.result, {BootstrapKind::kResiduals, 50, seed}).directions.front().rad;
  };
  EXPECT_EQ(sigma(1), sigma(1));
  EXPECT_NE(sigma(1), sigma(2));
}

TEST(Bootstrap, OneTrialIsNoScatter) {
  const Session r = session(1, what_targets_see());
  EXPECT_THROW(bootstrap(r.list, r.result, {BootstrapKind::kParametric, 1, 1}), Error);
}

}  // namespace
}  // namespace scatmap::calib::test
