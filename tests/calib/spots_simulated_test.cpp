// The simulator's mirror frames through the spot finder, against the simulator's truth. Its geometry and camera share
// no code with calib. Does not prove anything about the command line (tests/cli).
#include <gtest/gtest.h>

#include <Eigen/LU>

#include <filesystem>

#include "calib/spots.h"
#include "calib/targets.h"
#include "data-synthetic/simulate.h"
#include "scatmap/angles/instrument.h"

namespace scatmap::calib {
namespace {

class SimulatedSpots : public testing::TestWithParam<SpotMethod> {};

TEST_P(SimulatedSpots, CentroidsAgreeWithTruthWithinTheirSigma) {
  const std::filesystem::path folder =
      testing::TempDir() + "spots_simulated_" + std::to_string(static_cast<int>(GetParam()));
  std::filesystem::remove_all(folder);
  synth::simulate(SCATMAP_SOURCE_DIR "/data-synthetic/scenes/mirror-frames.toml", folder, Overwrite::kKeep,
                  {"test", "test", {}});
  const Instrument instrument = read_instrument(folder / "instrument.toml");
  const SensorModel sensor{instrument.sensor.gain_e_per_dn.value(),
                           instrument.sensor.read_noise_e.value(),
                           instrument.sensor.saturation_dn.value(),
                           instrument.sensor.bias_dn,
                           {}};
  const TargetList measured = read_targets(folder / "targets.csv"), truth = read_targets(folder / "truth/targets.csv");
  ASSERT_EQ(measured.targets.size(), 14u);
  double deviation2 = 0;
  for (std::size_t i = 0; i < 14; ++i) {
    const Frame frame = read_frame(folder / measured.targets[i].file);
    const SpotsInFrame found = find_spots(spot_image(frame, std::nullopt, sensor), GetParam());
    ASSERT_EQ(found.spots.size(), 1u) << measured.targets[i].file;
    const Spot& s = found.spots.front();
    EXPECT_EQ(s.flags, 0) << measured.targets[i].file;
    EXPECT_LE(s.sigma_px(), 0.003);
    const Eigen::Vector2d error(s.column_px - truth.targets[i].column_px, s.row_px - truth.targets[i].row_px);
    deviation2 += error.dot(s.covariance_px2.inverse() * error);
  }
  // chi-square of 28 degrees of freedom: 99.9 % lie between 9.7 and 59.
  EXPECT_GE(deviation2, 9.7);
  EXPECT_LE(deviation2, 59);
  std::filesystem::remove_all(folder);
}

INSTANTIATE_TEST_SUITE_P(Methods, SimulatedSpots,
                         testing::Values(SpotMethod::kMaximumLikelihood, SpotMethod::kMoments));

}  // namespace
}  // namespace scatmap::calib
