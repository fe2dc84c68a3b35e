// Real laser spots (tests/oracle/frames): the centroid must not move with the dark level, the crop or added noise.
// There is no truth to compare with: a bias common to all variants would not show.
#include <gtest/gtest.h>

#include <random>

#include "calib/spots.h"
#include "scatmap/frame/frame.h"

namespace scatmap::calib {
namespace {

constexpr double kStable_px = 0.05;

struct RealFrame {
  const char* file;
  SensorModel sensor;  // gain and read noise guessed from the frame: the files state none
  double noise_dn;     // about the frame's own
};

Frame with_level(Frame f, float level_dn) {
  for (float& v : f.dn.floats()) v += level_dn;
  return f;
}

Frame with_noise(Frame f, double sigma_dn, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, sigma_dn);
  for (float& v : f.dn.floats()) v += static_cast<float>(normal(random));
  return f;
}

Frame cropped(const Frame& f, int left, int top, int right, int bottom) {
  Frame out{Grid<float>(f.dn.rows() - top - bottom, f.dn.columns() - left - right), f.quantum_dn, f.file, {}};
  for (int r = 0; r < out.dn.rows(); ++r) {
    for (int c = 0; c < out.dn.columns(); ++c) out.dn(r, c) = f.dn(r + top, c + left);
  }
  return out;
}

class RealSpots : public testing::TestWithParam<std::tuple<RealFrame, SpotMethod>> {};

TEST_P(RealSpots, CentroidStaysUnderDarkLevelCropAndNoise) {
  const RealFrame& real = std::get<0>(GetParam());
  const SpotMethod method = std::get<1>(GetParam());  // clang 14 takes no structured binding into a lambda
  const Frame frame = read_frame(std::string(SCATMAP_TEST_DATA "/frames/") + real.file);
  const auto target = [&](const Frame& f, const SensorModel& sensor) {
    const SpotsInFrame found = find_spots(spot_image(f, std::nullopt, sensor), method);
    EXPECT_FALSE(found.spots.empty());
    return found.spots.empty() ? Spot{} : found.spots.front();
  };
  const Spot as_is = target(frame, real.sensor);
  const auto expect_same = [&](const Spot& s, double left, double top, const char* what) {
    EXPECT_NEAR(s.column_px + left, as_is.column_px, kStable_px) << what;
    EXPECT_NEAR(s.row_px + top, as_is.row_px, kStable_px) << what;
  };
  SensorModel raised = real.sensor;
  raised.saturation_dn += 100;
  expect_same(target(with_level(frame, 100), raised), 0, 0, "dark level");
  expect_same(target(cropped(frame, 100, 0, 60, 40), real.sensor), 100, 0, "crop");
  expect_same(target(cropped(frame, 60, 40, 130, 10), real.sensor), 60, 40, "another crop");
  expect_same(target(with_noise(frame, real.noise_dn, 3), real.sensor), 0, 0, "noise");
  expect_same(target(with_noise(frame, 2 * real.noise_dn, 4), real.sensor), 0, 0, "more noise");
}

INSTANTIATE_TEST_SUITE_P(Frames, RealSpots,
                         testing::Combine(testing::Values(RealFrame{"t-hene.pgm", {30, 15, 255, 0, {}}, 2},
                                                          RealFrame{"TEM00_200mm.pgm", {0.3, 20, 65535, 0, {}}, 100}),
                                          testing::Values(SpotMethod::kMaximumLikelihood, SpotMethod::kMoments)));

}  // namespace
}  // namespace scatmap::calib
