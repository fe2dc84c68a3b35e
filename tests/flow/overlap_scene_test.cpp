// The shipped scene overlap-20-0: the paper's case with filters and laser off within their tolerances and three
// exposures. From 59.3 % to below 2 %, the truth inside the 95 % interval, no visible seam between the exposures'
// ranges. The absolute scale rests on exposure 1 having the signature's own stack;
// tests/flow/uncertainty_chain_test.cpp counts coverage over many draws. Does not prove that re-inserting a stack
// reproduces its transmittance.
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <regex>

#include "data-synthetic/simulate.h"
#include "scatmap/base/output_file.h"
#include "scatmap/brdf/from_frames.h"
#include "scatmap/brdf/scale_statistics.h"
#include "scatmap/report/fits_file.h"

namespace scatmap {
namespace {

namespace fs = std::filesystem;

struct Range {
  double low = 0, high = 0;
  double measured = 0, truth = 0, variance = 0;
  double ratio() const { return measured / truth; }
  double u() const { return std::sqrt(variance) / truth; }
};

// Sums over pixels by their true BRDF: each range is served by other exposures.
std::vector<Range> by_level(const BrdfMap& map, const Grid<double>& truth) {
  std::vector<Range> out{{30, 100}, {100, 300}, {300, 1000}, {1000, 3000}, {3000, 10000}, {10000, 60000}};
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (map.mask[i] != 0) continue;
    for (Range& r : out) {
      if (!(truth[i] >= r.low && truth[i] < r.high)) continue;
      r.measured += map.brdf_per_sr[i];
      r.truth += truth[i];
      r.variance += static_cast<double>(map.u_random_per_sr[i]) * map.u_random_per_sr[i];
    }
  }
  return out;
}

TEST(OverlapScene, ScaleBelowTwoPerCentTruthInsideAndNoSeams) {
  const fs::path folder = fs::temp_directory_path() / ("scatmap-overlap-" + std::to_string(getpid()));
  fs::create_directories(folder);
  const std::string text =
      read_text_file(fs::path(SCATMAP_SOURCE_DIR) / "data-synthetic" / "scenes" / "overlap-20-0.toml");
  for (const char* seed : {"31", "32"}) {
    write_text_file(folder / "scene.toml",
                    std::regex_replace(text, std::regex("seed = [0-9]+"), std::string("seed = ") + seed),
                    Overwrite::kForce);
    synth::simulate(folder / "scene.toml", folder / "data", Overwrite::kForce, {});
    const BrdfResult r = brdf_from_frames(read_measurement(folder / "data" / "measurement.toml"));
    const Grid<double> truth = FitsReader(folder / "data" / "truth" / "brdf.fits").image_double("TRUTH_BRDF");
    EXPECT_NEAR(r.exposure_scale.at(1).filters_worst_case(), 0.593, 0.001);
    EXPECT_LE(r.map.scale.standard(), 0.02);
    EXPECT_TRUE(r.map.notes.empty()) << r.map.notes.front();
    const std::vector<Range> levels = by_level(r.map, truth);
    const FactorInterval interval =
        monte_carlo(r.map.scale, 0.001, 200'000).symmetric;  // 0.1 %: what ties the exposures
    for (const Range& level : levels) {
      EXPECT_GE(1 / level.ratio(), interval.low - 2 * level.u()) << level.low;
      EXPECT_LE(1 / level.ratio(), interval.high + 2 * level.u()) << level.low;
      EXPECT_LE(std::abs(level.ratio() / levels.back().ratio() - 1), 2e-3 + 3 * level.u()) << level.low;
      EXPECT_LE(level.u(), 2e-3) << level.low;
    }
    const BrdfResult nominal =
        brdf_from_frames(read_measurement(folder / "data" / "measurement.toml"), {}, FilterValues::kNominal);
    EXPECT_GT(std::abs(by_level(nominal.map, truth).front().ratio() / by_level(nominal.map, truth).back().ratio() - 1),
              0.1);
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace scatmap
