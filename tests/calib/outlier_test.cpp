// Wrong targets: 30 % spots that are anywhere and 10 % wrong angles are found and named, and the estimate is as good as
// without them. Does not prove anything about wrong angles that move a spot by less than its uncertainty.
#include <gtest/gtest.h>

#include <set>

#include "bench.h"
#include "calib/report.h"
#include "scatmap/base/error.h"

namespace scatmap::calib::test {
namespace {

Lab noisy_lab(std::mt19937_64& rng, std::size_t targets) {
  Lab lab{plain_bench(), {{"", 0.1, 0}}, random_plan(targets, rng), 0.1};
  synth::Bench& b = lab.bench;
  b.distance_mm = 329;
  b.offset_mm = {0.8, -0.5};
  b.rotation_deg = {0, 0, 0.7};
  b.stage_zero_deg = 0.12;
  b.arm_encoder_sigma_deg = b.stage_encoder_sigma_deg = 0.0005;
  return lab;
}

Instrument nominal_of(const Lab& lab) {
  synth::Bench b = plain_bench();
  b.arm_encoder_sigma_deg = lab.bench.arm_encoder_sigma_deg;
  b.stage_encoder_sigma_deg = lab.bench.stage_encoder_sigma_deg;
  return believed(b);
}

std::set<std::size_t> spoil(TargetList& list, double gross, double mislabelled, const Lab& lab, std::mt19937_64& rng) {
  std::set<std::size_t> wrong;
  std::vector<std::size_t> order(list.targets.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), rng);
  const auto n = static_cast<double>(order.size());
  const auto within = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng); };
  for (std::size_t k = 0; k < order.size(); ++k) {
    Target& t = list.targets[order[k]];
    if (static_cast<double>(k) < gross * n) {
      t.column_px = within(0, lab.bench.columns - 1);
      t.row_px = within(0, lab.bench.rows - 1);
    } else if (static_cast<double>(k) < (gross + mislabelled) * n) {
      // A wrong line of the log: the arm by whole tenths of a degree, or the sign of the tilt.
      t.arm_rad += (within(0, 1) < 0.5 ? 1 : -1) * std::ceil(within(0, 10)) * 0.1 * kRadPerDeg;
    } else {
      continue;
    }
    wrong.insert(order[k]);
  }
  return wrong;
}

TEST(Outliers, ThirtyPercentGrossAndTenPercentMislabelledAreNamed) {
  std::mt19937_64 rng(321);
  const char* const kCompared[] = {"detector.distance_mm", "detector.rotation_deg.2", "stage.zero_deg"};
  constexpr int kTrials = 60;
  int missed = 0, innocent = 0, wrong_targets = 0, good_targets = 0;
  std::map<std::string, double> sum2, sigma2;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Lab lab = noisy_lab(rng, 80);
    const TargetList clean = observe(lab, rng);
    TargetList list = clean;
    const std::set<std::size_t> wrong = spoil(list, 0.3, 0.1, lab, rng);
    const CalibrationResult r = calibrate(list, nominal_of(lab), {}), best = calibrate(clean, nominal_of(lab), {});
    for (std::size_t i = 0; i < list.targets.size(); ++i) {
      const bool spoilt = wrong.count(i) > 0;
      wrong_targets += spoilt ? 1 : 0;
      good_targets += spoilt ? 0 : 1;
      missed += spoilt && r.targets[i].used ? 1 : 0;
      innocent += !spoilt && !r.targets[i].used ? 1 : 0;
    }
    const std::vector<double> truth = true_values(lab);
    for (const char* const name : kCompared) {
      for (std::size_t i = 0; i < r.parameters.size(); ++i) {
        if (r.parameters[i].name != name) continue;
        sum2[name] += std::pow(r.parameters[i].value - truth[i], 2);
        sigma2[name] += std::pow(best.parameters[i].sigma, 2);
      }
    }
  }
  // A gross spot may fall within a few pixels of the right place by chance.
  EXPECT_LE(missed, wrong_targets / 200);
  EXPECT_LE(innocent, good_targets / 500);
  for (const char* const name : kCompared) {
    EXPECT_LE(std::sqrt(sum2[name] / sigma2[name]), 1.5) << name;
    std::printf("%s: rms error %.2f of the clean sigma\n", name, std::sqrt(sum2[name] / sigma2[name]));
  }
  std::printf("%d of %d wrong targets missed, %d of %d good ones lost\n", missed, wrong_targets, innocent,
              good_targets);
}

TEST(Outliers, ReportNamesLineAndFile) {
  std::mt19937_64 rng(322);
  const Lab lab = noisy_lab(rng, 60);
  TargetList list = observe(lab, rng);
  for (Target& t : list.targets) t.file = "frame" + std::to_string(t.line) + ".fits";
  list.targets[17].arm_rad += 0.3 * kRadPerDeg;
  const CalibrationResult r = calibrate(list, nominal_of(lab), {});
  const std::string text = report_text(list, r);
  EXPECT_NE(text.find("targets.csv:19 (frame19.fits)"), std::string::npos) << text;
  EXPECT_NE(text.find("1 targets do not fit"), std::string::npos) << text;
  EXPECT_EQ(text.find("targets.csv:20 "), std::string::npos);
}

TEST(Outliers, WrongKindIsFound) {
  std::mt19937_64 rng(323);
  const Lab lab = noisy_lab(rng, 60);
  TargetList list = observe(lab, rng);
  list.targets[9].kind = TargetKind::kSpecular;  // was direct: the mirror would send the beam elsewhere
  const CalibrationResult r = calibrate(list, nominal_of(lab), {});
  EXPECT_FALSE(r.targets[9].used);
  EXPECT_EQ(std::count_if(r.targets.begin(), r.targets.end(), [](const TargetResult& t) { return !t.used; }), 1);
}

TEST(Outliers, NonsenseIsRefused) {
  std::mt19937_64 rng(324);
  const Lab lab = noisy_lab(rng, 60);
  TargetList list = observe(lab, rng);
  spoil(list, 0.9, 0, lab, rng);
  EXPECT_THROW(calibrate(list, nominal_of(lab), {}), Error);
  for (Target& t : list.targets) t.arm_rad += 90 * kRadPerDeg;
  EXPECT_THROW(calibrate(list, nominal_of(lab), {}), Error);
}

// Sigmas that are three times too small are not an outlier problem; they are said to be too small.
TEST(Outliers, UnderstatedSigmasAreSaid) {
  std::mt19937_64 rng(325);
  const Lab lab = noisy_lab(rng, 80);
  TargetList list = observe(lab, rng);
  for (Target& t : list.targets) t.sigma_px /= 3;
  Instrument nominal = nominal_of(lab);
  nominal.arm_encoder_sigma_rad /= 3;
  nominal.stage_encoder_sigma_rad /= 3;
  const CalibrationResult r = calibrate(list, nominal, {});
  EXPECT_GT(std::count_if(r.targets.begin(), r.targets.end(), [](const TargetResult& t) { return t.used; }), 75);
  EXPECT_NE(report_text(list, r).find("sigmas are too small"), std::string::npos);
}

}  // namespace
}  // namespace scatmap::calib::test
