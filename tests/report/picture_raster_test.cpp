// Blocks and axes of drawn grids.
#include "scatmap/report/picture_raster.h"

#include <gtest/gtest.h>

#include <limits>

#include "compare/synthetic_map.h"

namespace scatmap {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Raster draw(const BrdfMap& map, int most_cells) {
  return raster(map.brdf_per_sr, map.mask, sample_view(map.instrument, map.pose), most_cells);
}

TEST(Raster, SmallMapsAreDrawnPixelByPixel) {
  const BrdfMap map = synthetic::noiseless(31, 21, [](double c, double r) { return 100 * r + c; });
  const Raster out = draw(map, 100);
  EXPECT_EQ(out.block, 1);
  ASSERT_EQ(out.values.size(), 31u * 21u);
  EXPECT_EQ(out.values[2 * 31 + 5], 205);
  const double pixel_deg = std::atan(13.5e-6 / 0.325) * kDegPerRad;
  EXPECT_LE(std::abs(out.step_x_deg / pixel_deg - 1), 1e-6);
  EXPECT_LE(std::abs(out.first_x_deg / (-15 * pixel_deg) - 1), 1e-6);
  EXPECT_LE(std::abs(out.first_y_deg / (-10 * pixel_deg) - 1), 1e-6);
}

TEST(Raster, BlocksAreMeansOfGoodPixels) {
  BrdfMap map = synthetic::noiseless(10, 7, [](double c, double r) { return 10 * r + c; });
  map.mask(0, 1) = kHot;
  map.brdf_per_sr(1, 0) = kNaN;
  for (int r = 3; r < 6; ++r) {
    for (int c = 3; c < 6; ++c) map.mask(r, c) = kBad;
  }
  const Raster out = draw(map, 4);
  EXPECT_EQ(out.block, 3);
  ASSERT_EQ(out.columns, 4);
  ASSERT_EQ(out.rows, 3);
  EXPECT_FLOAT_EQ(out.values[0], (99.0F - 1 - 10) / 7);  // the nine sum to 99
  EXPECT_TRUE(std::isnan(out.values[1 * 4 + 1]));
  EXPECT_FLOAT_EQ(out.values[2 * 4 + 3], 69);  // the last block holds one pixel
}

TEST(Raster, NarrowLobesDoNotVanish) {
  constexpr double kRadius = 5 / 1.6651;  // 5 px wide at half height
  for (const double at : {1024.0, 1025.5, 1027.0}) {
    const BrdfMap map = synthetic::noiseless(2400, 2100, synthetic::Lobe{at, at, 1000, kRadius});
    const Raster four = draw(map, 600);
    ASSERT_EQ(four.block, 4);
    EXPECT_GE(*std::max_element(four.values.begin(), four.values.end()), 400) << at;
    const Raster seven = draw(map, 343);
    ASSERT_EQ(seven.block, 7);
    EXPECT_GE(*std::max_element(seven.values.begin(), seven.values.end()), 200) << at;
  }
}

TEST(Raster, StorageOrderDoesNotMatter) {
  const auto field = [](double c, double r) { return 100 * r + c; };
  const BrdfMap plain = synthetic::noiseless(23, 17, field);
  const Raster expected = draw(plain, 100);
  BrdfMap flipped = synthetic::noiseless(23, 17, [&](double c, double r) { return field(22 - c, 16 - r); });
  flipped.instrument.flip_columns = flipped.instrument.flip_rows = true;
  const Raster out = draw(flipped, 100);
  EXPECT_EQ(out.values, expected.values);
  EXPECT_LE(std::abs(out.first_x_deg - expected.first_x_deg), 1e-12);
  EXPECT_LE(std::abs(out.first_y_deg - expected.first_y_deg), 1e-12);
  EXPECT_GT(out.step_x_deg, 0);
}

}  // namespace
}  // namespace scatmap
