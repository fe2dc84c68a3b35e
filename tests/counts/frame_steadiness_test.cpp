// What frames of one exposure are held against each other by: steady ones stay within the noise that is stated for
// their sums, and light that dims or moves is counted where it does, worked out by hand. Does not prove the limits at
// which the user is told (tests/cli/notes_test.cpp).
#include "scatmap/counts/frame_steadiness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/counts/made_frames.h"

namespace scatmap {
namespace {

constexpr int kSide = 60;
constexpr double kDark_e = 50;

struct Scene {
  std::vector<Frame> frames;
  MasterDark dark;
};

// A bright square of 20 x 20 pixels in the dark.
Grid<double> square(double light_e, int column) {
  Grid<double> out(kSide, kSide, kDark_e);
  for (int r = 20; r < 40; ++r) {
    for (int c = column; c < column + 20; ++c) out(r, c) += light_e;
  }
  return out;
}

Scene steady(int frames, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  const Grid<double> dark(kSide, kSide, kDark_e);
  return {test::made_frames(frames, square(20000, 20), 0, test::kSensor, rng),
          combine_darks(test::made_frames(7, dark, 0, test::kSensor, rng), test::kSensor)};
}

TEST(FrameSteadiness, SteadyFramesScatterByTheirNoise) {
  double square_sum = 0, u2 = 0;
  constexpr int kSeeds = 800;
  Scene s = steady(2, 1);
  std::mt19937_64 rng(2);
  for (int seed = 0; seed < kSeeds; ++seed) {
    s.frames = test::made_frames(2, square(20000, 20), 0, test::kSensor, rng);
    const FrameChanges found = frame_changes(s.frames, s.dark, test::kSensor, 1);
    ASSERT_EQ(found.pixels, 400u);
    ASSERT_EQ(found.of_frame[0].differing + found.of_frame[1].differing, 0u);
    square_sum += std::pow(found.of_frame[1].net_dn - found.of_frame[0].net_dn, 2);
    u2 += 2 * found.u_net_dn * found.u_net_dn;
  }
  EXPECT_NEAR(square_sum / u2, 1, 4 * std::sqrt(2.0 / kSeeds));
}

TEST(FrameSteadiness, DimmedAndMovedLightIsCounted) {
  Scene s = steady(3, 7);
  std::mt19937_64 rng(8);
  s.frames[2] = test::made_frames(1, square(18000, 20), 0, test::kSensor, rng).front();
  const FrameChanges dimmed = frame_changes(s.frames, s.dark, test::kSensor, 1);
  EXPECT_NEAR(dimmed.of_frame[2].net_dn / dimmed.of_frame[0].net_dn, 0.9, 0.002);
  // A square that moves by 4 columns leaves 4 of its 20 columns and lights 4 others, all bright in the frames' mean.
  s.frames[2] = test::made_frames(1, square(20000, 24), 0, test::kSensor, rng).front();
  const FrameChanges moved = frame_changes(s.frames, s.dark, test::kSensor, 1);
  EXPECT_EQ(moved.pixels, 24u * 20u);
  EXPECT_EQ(moved.of_frame[2].differing, 8u * 20u);
  const FrameChanges every_fourth = frame_changes(s.frames, s.dark, test::kSensor, 4);
  EXPECT_EQ(every_fourth.pixels, 24u * 5u);
  EXPECT_EQ(every_fourth.of_frame[2].differing, 8u * 5u);
}

TEST(FrameSteadiness, PixelsWithoutANumberDoNotCount) {
  Scene s = steady(2, 9);
  s.frames[1].dn(25, 25) = std::numeric_limits<float>::quiet_NaN();
  s.frames[0].dn(25, 26) = std::numeric_limits<float>::infinity();
  const FrameChanges found = frame_changes(s.frames, s.dark, test::kSensor, 1);
  EXPECT_EQ(found.pixels, 398u);
  EXPECT_TRUE(std::isfinite(found.of_frame[0].net_dn) && std::isfinite(found.of_frame[1].net_dn));
  EXPECT_TRUE(std::isfinite(found.u_net_dn));
}

}  // namespace
}  // namespace scatmap
