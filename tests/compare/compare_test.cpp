// The whole comparison on one synthetic scene, and what it refuses. Its parts are proven in the tests beside this one.
#include "scatmap/compare/compare.h"

#include <gtest/gtest.h>

#include "compare/synthetic_map.h"
#include "scatmap/base/error.h"

namespace scatmap {
namespace {

using synthetic::Comb;
using synthetic::Lobe;

synthetic::Field cell(double shift_px, double factor) {
  const Lobe centre{300.3, 280.7, 1.1e4, 9.6}, offset{421.15 + shift_px, 390.6, 4.4e4, 9.6};
  const Comb comb{300.3, 280.7, 90, 19, 300, 6};
  return [=](double c, double r) { return factor * (0.5 + centre(c, r) + offset(c, r) + comb(c, r)); };
}

TEST(Compare, FindsWhatDiffersAndWhatDoesNot) {
  const BrdfMap measured = synthetic::noisy(600, 560, cell(1.5, 1.2), 0.05, 0.5, 31);
  const Comparison c = compare(measured, synthetic::noiseless(600, 560, cell(0, 1)));
  ASSERT_EQ(c.peaks.size(), 2u);
  EXPECT_LE(std::abs(c.peaks[0].distance_px - 1.5), 0.01);
  EXPECT_LE(c.peaks[1].distance_px, 0.05);
  EXPECT_LE(std::abs(c.peaks[0].height_ratio - 1.2), 0.002);
  EXPECT_LE(std::abs(c.peaks[1].height_ratio - 1.2), 0.005);
  ASSERT_TRUE(c.measured.along_ridge && c.modelled.along_ridge && c.measured.along_column);
  EXPECT_EQ(c.measured.along_ridge->orders_after, 14);  // (559 − 280.7)/19 = 14.6
  EXPECT_EQ(c.measured.along_ridge->orders_before, 14);
  EXPECT_EQ(c.modelled.along_ridge->orders_after, 14);
  EXPECT_EQ(c.modelled.along_column->orders_before, 14);
  EXPECT_LE(std::abs(c.measured.along_ridge->spacing_px - c.modelled.along_ridge->spacing_px), 0.02);
  ASSERT_TRUE(c.residual);
  EXPECT_GE(c.residual->as_is.per_degree(), 10);
  EXPECT_EQ(c.columns.size(), 2u);
  EXPECT_EQ(c.columns[0].measured.size(), 560u);
  EXPECT_EQ(c.rows[1].modelled.size(), 600u);
  ASSERT_TRUE(c.ridge);
  EXPECT_EQ(c.ridge->measured.size(), c.ridge->modelled.size());
  EXPECT_LE(c.direction_difference_px, 1e-6);
}

TEST(Compare, TwoModelsHaveNoResidualButAllElse) {
  const BrdfMap a = synthetic::noiseless(600, 560, cell(0, 1));
  const Comparison c = compare(a, a);
  EXPECT_FALSE(c.residual);
  EXPECT_EQ(c.peaks.size(), 2u);
  EXPECT_EQ(c.log10_ratio(10, 10), 0);
}

TEST(Compare, FeaturelessMapsAreComparedToo) {
  const auto flat = [](double, double) { return 3.0; };
  const Comparison c = compare(synthetic::noisy(100, 90, flat, 0.1, 0, 32), synthetic::noiseless(100, 90, flat));
  EXPECT_TRUE(c.peaks.empty());
  EXPECT_FALSE(c.ridge);
  ASSERT_TRUE(c.residual);
  EXPECT_LE(std::abs(c.residual->as_is.per_degree() - 1), 4 * std::sqrt(2.0 / 9000));
}

TEST(Compare, MapsOfDifferentScenesAreErrors) {
  const BrdfMap a = synthetic::noiseless(60, 50, cell(0, 1));
  EXPECT_THROW(compare(a, synthetic::noiseless(60, 51, cell(0, 1))), Error);
  BrdfMap b = a;
  b.wavelength_m *= 1 + 2e-6;
  EXPECT_THROW(compare(a, b), Error);
  b = a;
  b.pose.arm_rad += 1e-6;
  EXPECT_THROW(compare(a, b), Error);
  b = a;
  b.pose.stage_rad += 1e-6;
  EXPECT_THROW(compare(a, b), Error);
  b = a;
  b.wavelength_m = std::nan("");
  EXPECT_THROW(compare(a, b), Error);
}

TEST(Compare, AnotherCalibrationOfTheInstrumentIsSeen) {
  const BrdfMap a = synthetic::noiseless(60, 50, cell(0, 1));
  BrdfMap b = a;
  b.instrument.geometry.offset_x = 27e-6;  // two pixels
  EXPECT_LE(std::abs(compare(a, b).direction_difference_px - 2), 1e-3);
}

}  // namespace
}  // namespace scatmap
