// The paper's solar cell (Small, Butler, Marciniak 2021, Sec. 4.4): its printed peak values, fringe counts and heights
// must be read off the model's map by the feature finders. Independent of this code: the numbers printed in the paper.
// Not proven here: anything about the paper's measured maps, which are not public.
#include <gtest/gtest.h>

#include "scatmap/base/units.h"
#include "scatmap/compare/compare.h"
#include "scatmap/compare/model_map.h"

namespace scatmap {
namespace {

BrdfMap solar_cell(double theta_i_deg, double phi_ref_deg) {
  Instrument instrument;
  instrument.columns = instrument.rows = 1000;
  instrument.geometry.distance = 0.325;
  instrument.geometry.pixel_column = instrument.geometry.pixel_row = 13.5e-6;
  MicrofacetTerm centre, offset;
  centre.rho = 0.015;
  centre.n = 3.6;
  centre.m = offset.m = 2e-4;
  offset.rho = 0.7;
  offset.n = 1.4;
  offset.dtheta_rad = 0.5 * kRadPerDeg;
  offset.dphi_rad = 45 * kRadPerDeg;
  StripesTerm stripes;
  stripes.rho = 300;
  stripes.a_m = 8e-4;
  stripes.b_m = 1e-5;
  stripes.c_m = 4e-5;
  Model model;
  model.wavelength_m = 632.8e-9;
  model.phi_ref_rad = phi_ref_deg * kRadPerDeg;
  model.terms = {centre, offset, stripes};
  return model_map(model, instrument, {theta_i_deg * kRadPerDeg, 2 * theta_i_deg * kRadPerDeg});
}

struct Printed {
  double theta_i_deg, centre_per_sr, offset_per_sr;
};

class PaperCell : public testing::TestWithParam<Printed> {};

TEST_P(PaperCell, HasThePrintedFeatures) {
  const MapFeatures f = find_features(solar_cell(GetParam().theta_i_deg, 0));
  ASSERT_EQ(f.peaks.size(), 2u);
  // Three digits are printed; the fringe under the centre lobe and the fit of a lobe that is no exact Gaussian share 1
  // %.
  EXPECT_LE(std::abs(f.peaks[0].height_per_sr / GetParam().offset_per_sr - 1), 0.01);
  EXPECT_LE(std::abs(f.peaks[1].height_per_sr / GetParam().centre_per_sr - 1), 0.01);
  EXPECT_LE(std::hypot(f.peaks[1].column_px - 499.5, f.peaks[1].row_px - 499.5), 0.02) << "specular is the centre";
  EXPECT_GT(f.peaks[0].column_px, 700) << "offset to the right";
  EXPECT_GT(f.peaks[0].row_px, 600) << "and down";

  ASSERT_TRUE(f.band);
  EXPECT_EQ(f.band->peak, 1u);
  EXPECT_LE(std::abs(f.band->axis_deg - 90), 0.05);
  ASSERT_TRUE(f.along_ridge && f.along_column);
  EXPECT_EQ(f.along_ridge->orders_before, 26);
  EXPECT_EQ(f.along_ridge->orders_after, 26);
  EXPECT_LE(std::abs(f.along_ridge->first_height_per_sr / 300 - 1), 0.02);
  EXPECT_LE(std::abs(f.along_ridge->last_height_per_sr / 209 - 1), 0.02);
  // Orders lie lambda/a apart in direction cosine.
  EXPECT_LE(std::abs(f.along_ridge->spacing_deg / (632.8e-9 / 8e-4 * kDegPerRad) - 1), 1e-3);
}
INSTANTIATE_TEST_SUITE_P(AsPrinted, PaperCell,
                         testing::Values(Printed{20, 1.11e4, 4.44e4}, Printed{60, 3.91e4, 4.19e5}));

TEST(PaperBand, StraightColumnLosesTheBentBandAtSixtyDegrees) {
  const MapFeatures f = find_features(solar_cell(60, 0));
  ASSERT_TRUE(f.along_ridge && f.along_column);
  EXPECT_LE(f.along_column->last_height_per_sr, 0.5 * f.along_ridge->last_height_per_sr);
  EXPECT_EQ(f.along_column->orders_after, 26);
}

TEST(PaperBand, BandTurnsWithTheSample) {
  const MapFeatures in_plane = find_features(solar_cell(40, 90));
  ASSERT_TRUE(in_plane.band);
  EXPECT_LE(std::abs(in_plane.band->axis_deg), 0.05);
  const MapFeatures oblique = find_features(solar_cell(40, 45));
  ASSERT_TRUE(oblique.band);
  // The band is where the half vector has equal and opposite components: hx = du/2 for an in-plane turn du of the
  // scattered ray and hy = dv/(2 cos theta_i) for an out-of-plane turn dv, hence dv/du = −cos theta_i.
  EXPECT_LE(std::abs(oblique.band->axis_deg + std::atan(std::cos(40 * kRadPerDeg)) * kDegPerRad), 0.1);
}

}  // namespace
}  // namespace scatmap
