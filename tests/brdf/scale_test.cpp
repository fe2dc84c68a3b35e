// The paper's two ND cases, the interval's asymmetry, and filters as physical objects that cancel.
#include "scatmap/brdf/scale.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"
#include "scatmap/base/units.h"
#include "scatmap/brdf/measurement.h"

namespace scatmap {
namespace {

Filter five_percent(const std::string& name, double od) { return {name, od, Distribution::kRectangular, 0.05 * od}; }

// Signature {4.0 + x}, x with ΣOD² = 1.4787 (design, section 2).
Measurement paper_case() {
  Measurement m;
  for (const auto& [name, od] :
       {std::pair{"nd40", 4.0}, {"nd30", 3.0}, {"nd03", 0.3}, {"x1", 1.0}, {"x2", 0.6}, {"x3", 0.3}}) {
    m.filters[name] = five_percent(name, od);
  }
  m.filters["x4"] = five_percent("x4", std::sqrt(1.4787 - 1.0 - 0.36 - 0.09));
  m.signatures.front().filters = {"nd40", "x1", "x2", "x3", "x4"};
  return m;
}

TEST(Scale, ThePapersTwoCases) {
  Measurement m = paper_case();
  Exposure sample;
  sample.filters = {"nd30", "nd03"};
  const ScaleBudget none_shared = exposure_scale(m, sample, {});
  EXPECT_NEAR(100 * none_shared.filters_worst_case(), 59.3, 0.05);
  EXPECT_NEAR(100 * none_shared.filters_standard(), 59.34 / std::sqrt(3.0), 0.05);
  EXPECT_NEAR(100 * none_shared.filters_interval().high, 80.9, 0.15);
  EXPECT_NEAR(100 * none_shared.filters_interval().low, -44.7, 0.1);
  sample.filters = {"nd40"};
  const ScaleBudget shared = exposure_scale(m, sample, {});
  EXPECT_NEAR(100 * shared.filters_worst_case(), 14.0, 0.05);
}

TEST(Scale, EqualStacksCancelExactly) {
  Measurement m = paper_case();
  Exposure sample;
  sample.filters = m.signatures.front().filters;
  EXPECT_EQ(exposure_scale(m, sample, {}).causes.size(), 0u);
  EXPECT_EQ(exposure_scale(m, sample, {}).standard(), 0);
}

TEST(Scale, TwoFiltersOfOneDensityAreTwoFilters) {
  Measurement m = paper_case();
  m.filters["other40"] = five_percent("other40", 4.0);
  Exposure sample;
  sample.filters = {"other40", "x1", "x2", "x3", "x4"};
  EXPECT_NEAR(exposure_scale(m, sample, {}).filters_worst_case(), kLn10 * 0.05 * std::sqrt(32.0), 1e-12);
}

TEST(Scale, StandardUncertaintiesAddToTheWorstCaseAsRectangularsOfTheSameSigma) {
  ScaleBudget b;
  b.causes = {{"filter a", Distribution::kNormal, 0.01, kLn10, true},
              {"filter b", Distribution::kRectangular, 0.01, -kLn10, true}};
  EXPECT_NEAR(b.filters_standard(), kLn10 * 0.01 * std::sqrt(1 + 1.0 / 3), 1e-15);
  EXPECT_NEAR(b.filters_worst_case() / b.filters_standard(), std::sqrt(3.0), 1e-14);
}

TEST(Scale, IntervalIsTenToPlusMinusDelta) {
  ScaleBudget b;
  b.causes = {{"filter a", Distribution::kRectangular, 0.2575, kLn10, true}};
  EXPECT_NEAR(b.filters_interval().high, std::pow(10, 0.2575) - 1, 1e-14);
  EXPECT_NEAR(b.filters_interval().low, std::pow(10, -0.2575) - 1, 1e-14);
}

// Every way to state a filter's uncertainty, through the file.
TEST(Scale, StatementsOfAFilter) {
  const std::filesystem::path folder = testing::TempDir();
  write_text_file(folder / "i.toml", "[detector]\ncolumns = 8\nrows = 8\npitch_um = [10, 10]\ndistance_mm = 300\n",
                  Overwrite::kForce);
  const auto read = [&](const std::string& filter) {
    write_text_file(
        folder / "m.toml",
        "instrument = \"i.toml\"\nwavelength_nm = 632.8\nstage_deg = 20\narm_deg = 40\n[filters.a]\nod = 2.0\n" +
            filter +
            "\n[laser]\ndrift_between_exposures_percent = 0.3\n[signature]\nframes = [\"s.fits\"]\ndarks = "
            "[\"d.fits\"]\n"
            "exposure_s = 1\n[[exposure]]\nframes = [\"e.fits\"]\ndarks = [\"d.fits\"]\nexposure_s = 1\nfilters = "
            "[\"a\"]\n",
        Overwrite::kForce);
    const Measurement m = read_measurement(folder / "m.toml");
    return exposure_scale(m, m.exposures.front(), {});
  };
  EXPECT_NEAR(read("tolerance_percent = 5").filters_standard(), kLn10 * 0.1 / std::sqrt(3.0), 1e-15);
  EXPECT_NEAR(read("tolerance_od = 0.1\ndistribution = \"triangular\"").filters_standard(),
              kLn10 * 0.1 / std::sqrt(6.0), 1e-15);
  EXPECT_NEAR(read("u_od = 0.02").filters_standard(), kLn10 * 0.02, 1e-15);
  EXPECT_NEAR(read("bounds_od = [-0.02, 0.1]").filters_standard(), kLn10 * 0.12 / std::sqrt(12.0), 1e-15);
  EXPECT_NEAR(read("u_od = 0").standard(), 0.003 / std::sqrt(3.0), 1e-15);  // the laser's own
  EXPECT_THROW(read("bounds_od = [0.02, 0.1]"), Error);
  EXPECT_THROW(read("u_od = 0.1\nbounds_od = [-0.02, 0.1]"), Error);
  EXPECT_THROW(read("u_od = 0.1\ndistribution = \"triangular\""), Error);
}

TEST(Scale, LaserTimesAndSignatureCountBesideTheFilters) {
  Measurement m;
  m.laser_drift = 0.03;
  m.signatures.front().u_exposure = 0.01;
  Exposure sample;
  sample.u_exposure = 0.02;
  EXPECT_NEAR(exposure_scale(m, sample, {0.005}).standard(), std::sqrt(0.03 * 0.03 / 3 + 1e-4 + 4e-4 + 2.5e-5), 1e-15);
  EXPECT_EQ(exposure_scale(m, sample, {0.005}).filters_worst_case(), 0);
}

}  // namespace
}  // namespace scatmap
