// The paper's two ND cases, the interval's asymmetry, and filters as physical objects that cancel.
#include "scatmap/brdf/scale.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"
#include "scatmap/base/units.h"
#include "scatmap/brdf/exposure_causes.h"
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

// A filter of all signature exposures cancels, one of some of them counts by their share.
TEST(Scale, SeveralSignatureExposures) {
  Measurement m = paper_case();
  m.signatures.push_back({});
  m.signatures[1].filters = {"nd40", "x1"};
  m.signatures[1].u_exposure = 0.01;
  Exposure sample;
  sample.filters = {"nd40"};
  const ScaleBudget b = exposure_scale(m, sample, {0, {0.7, 0.3}});
  ASSERT_EQ(b.causes.size(), 5u);  // x1 to x4, the second exposure's time
  EXPECT_NEAR(b.causes[0].sensitivity, -kLn10, 1e-12);
  for (int i = 1; i < 4; ++i) EXPECT_NEAR(b.causes[static_cast<std::size_t>(i)].sensitivity, -0.7 * kLn10, 1e-12);
  EXPECT_EQ(b.causes[4].name, "exposure time of signature exposure 2");
  EXPECT_NEAR(b.causes[4].sensitivity, 0.3, 1e-15);
}

// By identity over sample and signature: what is made relative to the beam's sum is what exposure_scale says of it.
TEST(Scale, CausesOfAllExposuresReferToTheBeamsSum) {
  Measurement m = paper_case();
  m.laser_drift_between_exposures = 0.002;
  m.signatures.push_back({});
  m.signatures[1].filters = {"nd40", "x2"};
  m.exposures.resize(2);
  m.exposures[0].filters = {"nd40"};
  m.exposures[1].filters = {"nd30", "nd03"};
  const std::vector<double> share{0.6, 0.4};
  std::vector<ScaleBudget> first, all;
  for (const Exposure& e : m.exposures) {
    first.push_back(exposure_scale(m, e, {}));
    all.push_back(exposure_scale(m, e, {0, share}));
  }
  ExposureCauses causes = causes_by_identity(first, {signature_scale(m, 0), signature_scale(m, 1)});
  causes.refer_to(share);
  for (Eigen::Index e = 0; e < 2; ++e) {
    double claimed = 0;
    for (std::size_t k = 0; k < causes.causes.size(); ++k)
      claimed += std::pow(causes.sensitivity(e, static_cast<Eigen::Index>(k)) * causes.causes[k].standard(), 2);
    EXPECT_NEAR(std::sqrt(claimed), all[static_cast<std::size_t>(e)].standard(), 1e-12);
  }
  const auto find = [&](const std::string& name) {
    for (std::size_t k = 0; k < causes.causes.size(); ++k) {
      if (causes.causes[k].name == name) return k;
    }
    return std::size_t{99};
  };
  EXPECT_TRUE(causes.is_common(find("filter x1")));
  EXPECT_TRUE(causes.is_measurable(find("filter x1")));
  EXPECT_FALSE(causes.is_measurable(find("filter x2")));  // in both beam stacks, in no sample stack
  EXPECT_FALSE(causes.is_common(find("filter nd40")));
}

TEST(Scale, TwoFormsOfTheSignatureInAFile) {
  const std::filesystem::path folder = testing::TempDir();
  write_text_file(folder / "i.toml", "[detector]\ncolumns = 8\nrows = 8\npitch_um = [10, 10]\ndistance_mm = 300\n",
                  Overwrite::kForce);
  const auto read = [&](const std::string& signature) {
    write_text_file(folder / "m.toml",
                    "instrument = \"i.toml\"\nwavelength_nm = 632.8\nstage_deg = 20\narm_deg = 40\n[signature]\n" +
                        signature + "[[exposure]]\nframes = [\"e.fits\"]\ndarks = [\"d.fits\"]\nexposure_s = 1\n",
                    Overwrite::kForce);
    return read_measurement(folder / "m.toml");
  };
  const std::string frames = "frames = [\"s.fits\"]\ndarks = [\"d.fits\"]\n", one = "exposure_s = 3\n" + frames;
  EXPECT_EQ(read(one).signatures.at(0).exposure_s, 3);
  const Measurement two = read("arm_deg = 180\naperture_radius_px = 7\n[[signature.exposure]]\n" + one +
                               "[[signature.exposure]]\nexposure_s = 4\nframes = [\"t.fits\"]\ndarks = [\"d.fits\"]\n");
  ASSERT_EQ(two.signatures.size(), 2u);
  EXPECT_EQ(two.signatures[1].exposure_s, 4);
  EXPECT_EQ(two.aperture.radius_px, 7);
  EXPECT_THROW(read(one + "[[signature.exposure]]\n" + one), Error);
  EXPECT_THROW(read("[[signature.exposure]]\nframe = []\n" + one), Error);
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
