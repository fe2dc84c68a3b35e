// The simulator's shipped mirror scenes, from files to files: directions of the calibrated instrument against the
// truth, the written instrument read back, and nominal files that are badly wrong with nothing but default options.
// Does not prove the frames to spots step.
#include <gtest/gtest.h>

#include <filesystem>

#include "calib/report.h"
#include "data-synthetic/scene.h"
#include "data-synthetic/simulate.h"
#include "monte_carlo.h"
#include "scatmap/base/output_file.h"

namespace scatmap::calib::test {
namespace {

namespace fs = std::filesystem;

struct Simulated {
  Lab lab;
  TargetList list;
  Instrument nominal;
};

Simulated simulated(const std::string& name) {
  const fs::path scene_file = fs::path(SCATMAP_SOURCE_DIR) / "data-synthetic/scenes" / (name + ".toml");
  const fs::path folder = fs::path(testing::TempDir()) / ("calib_" + name);
  fs::remove_all(folder);
  synth::simulate(scene_file, folder, Overwrite::kKeep, {"test", "test", {}});
  const synth::Scene scene = synth::read_scene(scene_file);
  Simulated out{{scene.bench, {}, {}, scene.mirror->sigma_px},
                read_targets(folder / "targets.csv"),
                read_instrument(folder / "instrument.toml")};
  for (const synth::MirrorMount& m : scene.mirror->mounts) out.lab.mounts.push_back({m.name, m.tilt_deg, m.height_mm});
  fs::remove_all(folder);
  return out;
}

// Directions against the mount whose tilt and height the directions are reported for.
void expect_directions(const Simulated& s, const CalibrationResult& r, double sigmas) {
  Instrument calibrated = r.instrument;
  if (s.lab.mounts.size() > 1) {
    calibrated.geometry.sample_tilt = r.values[ParameterTable::index_of_key(kTiltColumn, 0)];
    calibrated.geometry.sample_height = r.values[ParameterTable::index_of_key(kHeightColumn, 0)];
  }
  for (const DirectionSigma& d : r.directions) {
    const Eigen::Vector2d e = direction_error_px(s.lab, calibrated, d.point);
    EXPECT_LE(std::abs(e[0]), sigmas * d.column_px) << d.point.where;
    EXPECT_LE(std::abs(e[1]), sigmas * d.row_px) << d.point.where;
  }
}

TEST(Simulated, AlignedBenchStaysAsItIs) {
  const Simulated s = simulated("mirror-aligned");
  const CalibrationResult r = calibrate(s.list, s.nominal);
  expect_directions(s, r, 3.5);
  for (const ParameterResult& p : r.parameters) {
    if (p.sigma > 0) {
      EXPECT_LE(std::abs(p.value - p.nominal), 4 * p.sigma) << p.name;
    }
  }
}

TEST(Simulated, EveryParameterIsFound) {
  const Simulated s = simulated("mirror-every-parameter");
  const CalibrationResult r = calibrate(s.list, s.nominal);
  expect_directions(s, r, 3.5);
  EXPECT_LE(r.iterations, 15);
}

TEST(Simulated, WrittenInstrumentReadsBack) {
  const Simulated s = simulated("mirror-every-parameter");
  const CalibrationResult r = calibrate(s.list, s.nominal);
  const Instrument back = parse_instrument(to_toml(r.instrument), "calibrated.toml");
  ASSERT_TRUE(back.calibration.has_value());
  EXPECT_EQ(back.calibration->parameters, r.instrument.calibration->parameters);
  EXPECT_EQ(back.calibration->covariance, r.instrument.calibration->covariance);
  ASSERT_EQ(back.calibration->left_out.size(), r.instrument.calibration->left_out.size());
  ASSERT_FALSE(back.calibration->left_out.empty());
  for (std::size_t i = 0; i < back.calibration->left_out.size(); ++i) {
    EXPECT_EQ(back.calibration->left_out[i].name, r.instrument.calibration->left_out[i].name);
    EXPECT_EQ(back.calibration->left_out[i].reason, r.instrument.calibration->left_out[i].reason);
    EXPECT_EQ(back.calibration->left_out[i].bound_px, r.instrument.calibration->left_out[i].bound_px);
  }
  EXPECT_EQ(back.flip_columns, true);
  EXPECT_NEAR(back.geometry.distance, r.values[0], 1e-15);
}

TEST(Simulated, ReportBeginsWithDirectionsAndNamesWhatIsBlind) {
  const Simulated s = simulated("mirror-every-parameter");
  const CalibrationResult r = calibrate(s.list, s.nominal);
  const std::string text = report_text(s.list, r), json = report_json(s.list, r);
  EXPECT_EQ(text.rfind("direction of a pixel", 0), 0u);
  EXPECT_NE(text.find("the targets do not see beam.offset_mm.0"), std::string::npos);
  EXPECT_NE(text.find("arm.zero_deg"), std::string::npos);
  EXPECT_EQ(json.find("nan"), std::string::npos);
  EXPECT_LT(json.find("\"directions\""), json.size());
}

// Distance off by 30 %, every rotation by 10 degrees, axes reversed: only default options.
TEST(Simulated, BadNominalFilesWithDefaultOptions) {
  const Noise noise{0.05, 0.0005};
  std::mt19937_64 rng(371);
  const Instrument good = nominal_instrument(noise);
  const ParameterTable table(good, {"", {""}, {}}, {});
  constexpr int kTrials = 40;
  int outside = 0, points = 0;
  for (int i = 0; i < kTrials; ++i) {
    const Lab lab = drawn_lab(rng, noise, 100, table);
    const TargetList list = observe(lab, rng);
    Instrument bad = good;
    bad.geometry.distance *= i % 2 == 0 ? 0.7 : 1.3;
    bad.geometry.rotation_roll += (i % 4 < 2 ? 10 : -10) * kRadPerDeg;
    bad.geometry.rotation_pitch += (i % 8 < 4 ? 10 : -10) * kRadPerDeg;
    bad.geometry.rotation_yaw += (i % 3 == 0 ? 10 : -10) * kRadPerDeg;
    bad.flip_rows = i % 5 == 0;
    const CalibrationResult r = calibrate(list, bad);
    EXPECT_EQ(r.instrument.flip_rows, false) << i;
    for (const DirectionSigma& d : r.directions) {
      const Eigen::Vector2d e = direction_error_px(lab, r.instrument, d.point);
      outside += std::abs(e[0]) <= 3 * d.column_px && std::abs(e[1]) <= 3 * d.row_px ? 0 : 1;
      ++points;
    }
  }
  std::printf("%d of %d directions outside three sigma\n", outside, points);
  EXPECT_LE(outside, points / 20);
}

}  // namespace
}  // namespace scatmap::calib::test
