// Direction and ridge of known fringe bands. Not proven here: bands that are no polynomial of fourth degree.
#include "scatmap/compare/band.h"

#include <gtest/gtest.h>

#include "compare/synthetic_map.h"

namespace scatmap {
namespace {

using synthetic::Comb;
using synthetic::Lobe;

// Angle between two axes, deg: both are without head and tail.
double axis_difference(double a, double b) { return std::abs(std::remainder(a - b, 180)); }

BrdfMap cell(double axis_deg, double bend, unsigned seed) {
  const Lobe centre{300.3, 280.7, 1.1e4, 9.6}, offset{421.15, 390.6, 4.4e4, 9.6};
  const Comb comb{300.3, 280.7, axis_deg, 19, 300, 6, bend};
  return synthetic::noisy(
      600, 560, [=](double c, double r) { return 0.5 + centre(c, r) + offset(c, r) + comb(c, r); }, 0.3, 2, seed);
}

class BandAxis : public testing::TestWithParam<double> {};

TEST_P(BandAxis, IsFoundWithinAFifthOfADegree) {
  const BrdfMap map = cell(GetParam(), 0, 11);
  const auto band = find_band(map, find_peaks(map));
  ASSERT_TRUE(band);
  EXPECT_LE(axis_difference(band->axis_deg, GetParam()), 0.05);
  EXPECT_GE(band->axis_deg, -45);
  EXPECT_LT(band->axis_deg, 135);
  EXPECT_EQ(band->peak, 1u) << "the band passes through the lower peak";
  EXPECT_LE(std::abs(band->radius_px - 6), 0.5);
  EXPECT_GE(band->concentration, 0.8);
}
INSTANTIATE_TEST_SUITE_P(AllAround, BandAxis, testing::Values(-40.0, 0.0, 3.3, 45.0, 71.7, 88.8, 90.0, 91.5, 130.0));

TEST(Band, BentRidgeIsFollowed) {
  const double bend = 1.4e-4;  // 10 px at the frame's edge, as at 60 degrees incidence
  for (const double axis : {90.0, 60.0}) {
    const BrdfMap map = cell(axis, bend, 12);
    const auto band = find_band(map, find_peaks(map));
    ASSERT_TRUE(band);
    EXPECT_LE(axis_difference(band->axis_deg, axis), 0.2);
    const double a = axis * kRadPerDeg;
    for (double along = -240; along <= 240; along += 20) {
      const PixelPosition at = band->at(along);
      const double x = (at.column - 300.3) * std::cos(a) + (at.row - 280.7) * std::sin(a);
      const double y = -(at.column - 300.3) * std::sin(a) + (at.row - 280.7) * std::cos(a);
      EXPECT_LE(std::abs(y - bend * x * x), 0.4) << "axis " << axis << ", along " << along;
    }
  }
}

// Real lobes have skirts; these outshine the fringes far beyond the lobes' Gaussian reach.
TEST(Band, HalosAroundThePeaksDoNotHideIt) {
  const Lobe centre{300.3, 280.7, 1.1e4, 9.6}, offset{421.15, 390.6, 4.4e4, 9.6};
  const Comb comb{300.3, 280.7, 20, 19, 300, 6};
  const auto halo = [](const Lobe& lobe, double c, double r, double height) {
    return height / (1 + (std::pow(c - lobe.column, 2) + std::pow(r - lobe.row, 2)) / 100);
  };
  const BrdfMap map = synthetic::noisy(
      600, 560,
      [&](double c, double r) {
        return 3 + centre(c, r) + offset(c, r) + comb(c, r) + halo(centre, c, r, 150) + halo(offset, c, r, 600);
      },
      0.5, 3, 17);
  const auto band = find_band(map, find_peaks(map));
  ASSERT_TRUE(band);
  EXPECT_EQ(band->peak, 1u);
  EXPECT_LE(axis_difference(band->axis_deg, 20), 0.2);
}

TEST(Band, GivenAxisIsTakenAsTheStart) {
  const BrdfMap map = cell(90, 0, 13);
  const auto band = find_band(map, find_peaks(map), 89);
  ASSERT_TRUE(band);
  EXPECT_EQ(band->chord_deg, 89);
  EXPECT_LE(axis_difference(band->axis_deg, 90), 0.2);
}

TEST(Band, RidgeProfileRunsFromEdgeToEdgeAtFullHeight) {
  const BrdfMap map = cell(90, 1.4e-4, 14);
  const auto band = find_band(map, find_peaks(map));
  ASSERT_TRUE(band);
  const Profile ridge = ridge_profile(map, *band);
  EXPECT_LE(ridge.position.front().row, 1);
  EXPECT_GE(ridge.position.back().row, 558);
  double highest_near_edge = 0;
  for (std::size_t i = 0; i < ridge.size(); ++i) {
    if (ridge.position[i].row > 520) highest_near_edge = std::max(highest_near_edge, ridge.value_per_sr[i]);
  }
  EXPECT_GE(highest_near_edge, 270);  // the straight column is down to 300·exp(−(8/6)²) = 50 there
}

TEST(Band, DirectionInTheHemisphereIsThePixelDirectionOfAnIdealDetector) {
  // Columns grow with theta_s and rows with +y, at equal pitch: both angles are the same.
  for (const double axis : {0.0, 30.0, 90.0}) {
    const BrdfMap map = cell(axis, 0, 15);
    const auto band = find_band(map, find_peaks(map));
    ASSERT_TRUE(band);
    EXPECT_LE(axis_difference(band->direction_deg, band->axis_deg), 0.1) << axis;
  }
}

TEST(Band, MapsWithoutABandHaveNone) {
  const Lobe lobe{300, 280, 1e4, 9};
  const BrdfMap lobe_only = synthetic::noisy(600, 560, lobe, 0.3, 1, 16);
  EXPECT_FALSE(find_band(lobe_only, find_peaks(lobe_only)));
  EXPECT_FALSE(find_band(lobe_only, {}));
  const BrdfMap clean = synthetic::noiseless(600, 560, lobe);
  EXPECT_FALSE(find_band(clean, find_peaks(clean)));
}

}  // namespace
}  // namespace scatmap
