// Lines through maps with known values. Bilinear samples of a plane are exact; how far they are off on a curved lobe
// is not proven here.
#include "scatmap/compare/profile.h"

#include <gtest/gtest.h>

#include <limits>

#include "compare/synthetic_map.h"
#include "scatmap/base/error.h"

namespace scatmap {
namespace {

double plane(double c, double r) { return 10 + 0.3 * c - 0.2 * r; }

TEST(Profile, ColumnAndRowAreTheStoredPixels) {
  const BrdfMap map = synthetic::noiseless(40, 30, plane);
  const Profile column = column_profile(map, {12.4, 7.6});
  ASSERT_EQ(column.size(), 30u);
  EXPECT_EQ(column.value_per_sr[3], map.brdf_per_sr(3, 12));
  EXPECT_EQ(column.offset_px[8], 0);
  EXPECT_EQ(column.offset_px[3], -5);
  EXPECT_TRUE(column.u_random_per_sr.empty());
  const Profile row = row_profile(map, {12.4, 7.6});
  ASSERT_EQ(row.size(), 40u);
  EXPECT_EQ(row.value_per_sr[3], map.brdf_per_sr(8, 3));
  EXPECT_EQ(row.offset_px[3], -9);
}

TEST(Profile, AnglesAreThoseOfTheDetectorPlane) {
  // At the frame's centre a pixel offset d is seen under atan(d·pitch/R).
  const BrdfMap map = synthetic::noiseless(41, 31, plane);
  const Profile column = column_profile(map, {20, 15});
  for (std::size_t i = 0; i < column.size(); ++i) {
    const double expected = std::atan(column.offset_px[i] * 13.5e-6 / 0.325) * kDegPerRad;
    EXPECT_LE(std::abs(column.angle_deg[i] - expected), 1e-9);
  }
}

TEST(Profile, LineAtAnyAngleIsBilinear) {
  const BrdfMap map = synthetic::noiseless(40, 30, plane);
  for (const double axis : {0.0, 33.0, 90.0, 120.0}) {
    const Profile line = line_profile(map, {18.3, 14.7}, axis);
    ASSERT_GE(line.size(), 20u);
    for (std::size_t i = 0; i < line.size(); ++i) {
      const double c = 18.3 + line.offset_px[i] * std::cos(axis * kRadPerDeg);
      const double r = 14.7 + line.offset_px[i] * std::sin(axis * kRadPerDeg);
      EXPECT_LE(std::abs(line.value_per_sr[i] - plane(c, r)), 1e-9) << axis;
    }
  }
}

TEST(Profile, RandomUncertaintyOfABilinearSample) {
  BrdfMap map = synthetic::noiseless(4, 4, plane);
  map.u_random_per_sr = Grid<float>(4, 4, 2.0F);
  EXPECT_DOUBLE_EQ(sample_map(map, {1, 2}).u_random_per_sr, 2);
  EXPECT_DOUBLE_EQ(sample_map(map, {1.5, 2}).u_random_per_sr, std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(sample_map(map, {1.5, 1.5}).u_random_per_sr, 1);
}

TEST(Profile, BadPixelsMakeNan) {
  BrdfMap map = synthetic::noiseless(10, 10, plane);
  map.mask(5, 5) = kHot;
  map.brdf_per_sr(2, 5) = std::numeric_limits<double>::quiet_NaN();
  const Profile column = column_profile(map, {5, 4});
  EXPECT_TRUE(std::isnan(column.value_per_sr[5]));
  EXPECT_TRUE(std::isnan(column.value_per_sr[2]));
  EXPECT_TRUE(std::isfinite(column.value_per_sr[4]));
  EXPECT_TRUE(std::isnan(sample_map(map, {4.5, 5}).value_per_sr));
  EXPECT_DOUBLE_EQ(sample_map(map, {4, 5}).value_per_sr, plane(4, 5)) << "a neighbour without a share does no harm";
  EXPECT_TRUE(std::isnan(sample_map(map, {-0.5, 5}).value_per_sr));
}

TEST(Profile, OriginOffTheMapIsAnError) {
  const BrdfMap map = synthetic::noiseless(10, 10, plane);
  EXPECT_THROW(column_profile(map, {11, 3}), Error);
  EXPECT_THROW(row_profile(map, {3, -2}), Error);
  EXPECT_THROW(line_profile(map, {3, std::numeric_limits<double>::quiet_NaN()}, 0), Error);
}

}  // namespace
}  // namespace scatmap
