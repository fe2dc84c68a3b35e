// The diffraction term (Eqs. 9, 10): where its maxima lie (grating equation, an independent law), how far the paper's
// form and the grating form part, how the pattern turns, and limits. Not proven: amplitudes of a real grating (no
// shadowing, no polarisation, one width c); that needs measurements.
#include "scatmap/model/stripes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "model/scene.h"

namespace scatmap {
namespace {

using test::direction_deg;
using test::one_term;
using test::source_deg;

constexpr double kWavelength_m = 632.8e-9;

double brdf(const Model& model, const Vector3<double>& wi, const Vector3<double>& ws) {
  return PreparedModel(model, wi, test::kDistance_m)(ws);
}

// On the crest of the pattern, where the half vector has no component along the stripes, a distance `across` from
// specular in direction cosines, for stripes along x (phi_ref 0) and along y (phi_ref 90).
Vector3<double> crest_stripes_along_x(double theta_i_deg, double across) {
  const double x = std::sin(theta_i_deg * kRadPerDeg);
  return {x, across, std::sqrt(1 - x * x - across * across)};
}
Vector3<double> crest_stripes_along_y(double theta_i_deg, double across) {
  const double x = std::sin(theta_i_deg * kRadPerDeg) + across;
  return {x, 0, std::sqrt(1 - x * x)};
}

// Positions of the maxima of f on [low, high], to about 1e-4 of a step by a parabola.
std::vector<double> maxima(const std::function<double(double)>& f, double low, double high) {
  constexpr int kSteps = 40000;
  const double step = (high - low) / kSteps;
  std::vector<double> found;
  for (int i = 1; i < kSteps; ++i) {
    const double x = low + i * step, before = f(x - step), at = f(x), after = f(x + step);
    if (at > before && at >= after) found.push_back(x + step * (before - after) / (2 * (before - 2 * at + after)));
  }
  return found;
}

StripesTerm fine_stripes(StripesForm form) {
  StripesTerm term = test::stripes_term();
  term.b_m = 1e-9;  // no sinc and no edge of the pattern to pull the maxima
  term.c_m = 10;
  term.form = form;
  return term;
}

using Path = std::function<Vector3<double>(double)>;  // a direction per distance from specular

struct Parting {
  double largest_orders = 0;
  int compared = 0;
};

// Largest distance between the same maximum of the two forms, in orders, on both sides of specular up to `edge`.
Parting parting(double phi_ref_deg, double theta_i_deg, const Path& path, double edge) {
  const PreparedModel paper(one_term(fine_stripes(StripesForm::kPaper), phi_ref_deg), source_deg(theta_i_deg), 0.325);
  const PreparedModel grating(one_term(fine_stripes(StripesForm::kGrating), phi_ref_deg), source_deg(theta_i_deg),
                              0.325);
  Parting result;
  for (const double side : {-1.0, 1.0}) {
    const auto on = [&](const PreparedModel& model) {
      return maxima([&](double s) { return model(path(side * s)); }, edge / 100, edge);
    };
    const std::vector<double> p = on(paper), g = on(grating);
    for (std::size_t k = 0; k < std::min(p.size(), g.size()); ++k) {
      result.largest_orders = std::max(result.largest_orders, std::abs(p[k] - g[k]) / (p[1] - p[0]));
      ++result.compared;
    }
  }
  return result;
}

TEST(StripesGrating, MaximaObeyTheGratingEquation) {
  for (const double theta_i_deg : {0.0, 20.0, 60.0}) {
    const PreparedModel model(one_term(fine_stripes(StripesForm::kGrating), 90), source_deg(theta_i_deg), 0.325);
    const double spacing = kWavelength_m / 8e-4;
    const auto found =
        maxima([&](double s) { return model(crest_stripes_along_y(theta_i_deg, s)); }, -10.5 * spacing, 10.5 * spacing);
    ASSERT_EQ(found.size(), 21U);
    for (int k = -10; k <= 10; ++k) EXPECT_NEAR(found[static_cast<std::size_t>(k + 10)] / spacing, k, 1e-4);
  }
}

TEST(StripesForms, AgreeAtPhiRefZeroDownTheMiddleColumn) {
  for (const double theta_i_deg : {20.0, 40.0, 60.0}) {
    const Path column = [&](double down_m) { return test::sensor_direction(theta_i_deg, 0, down_m); };
    const Parting found = parting(0, theta_i_deg, column, test::kHalfHeight_m);
    EXPECT_EQ(found.compared, 52);
    EXPECT_LE(found.largest_orders, 0.003) << theta_i_deg;
  }
}

// Along the crest, which bends away from the middle column, the half vector's length makes the k-th maxima part by
// k s²/(8 cos² theta_i), s their direction cosine: 0.0055 order at 60 deg.
TEST(StripesForms, PartBySecondOrderAlongTheCrestAtPhiRefZero) {
  for (const double theta_i_deg : {20.0, 40.0, 60.0}) {
    const Path crest = [&](double s) { return crest_stripes_along_x(theta_i_deg, s); };
    const Parting found = parting(0, theta_i_deg, crest, 26.25 * kWavelength_m / 8e-4);
    EXPECT_EQ(found.compared, 52);
    const double c = std::cos(theta_i_deg * kRadPerDeg), s = 26 * kWavelength_m / 8e-4;
    EXPECT_NEAR(found.largest_orders, 26 * s * s / (8 * c * c), 1e-4) << theta_i_deg;
  }
}

TEST(StripesForms, PartByUpToAQuarterOrderAtPhiRefNinety) {
  const double expected_orders[] = {0.09, 0.17, 0.23};  // notes on the field, at the frame's edge
  int i = 0;
  for (const double theta_i_deg : {20.0, 40.0, 60.0}) {
    const Path row = [&](double right_m) { return test::sensor_direction(theta_i_deg, right_m, 0); };
    const Parting found = parting(90, theta_i_deg, row, test::kHalfHeight_m);
    EXPECT_GE(found.compared, 25);
    EXPECT_NEAR(found.largest_orders, expected_orders[i++], 0.02) << theta_i_deg;
  }
}

TEST(Stripes, TurningThemIsTurningTheDirectionsBack) {
  for (const auto form : {StripesForm::kPaper, StripesForm::kGrating}) {
    StripesTerm term = test::stripes_term();
    term.form = form;
    term.c_m = 5e-3;  // wide, so that the phase shows
    const double there = brdf(one_term(term, 33), direction_deg(40, 180), direction_deg(40.4, 0.5));
    const double back = brdf(one_term(term), direction_deg(40, 180 - 33), direction_deg(40.4, 0.5 - 33));
    EXPECT_NEAR(there, back, 1e-9 * 300);
    EXPECT_GT(std::abs(there - brdf(one_term(term), direction_deg(40, 180), direction_deg(40.4, 0.5))), 1);
  }
}

// At specular all phases are 0: the largest value, rho, exactly.
TEST(Stripes, AreRhoAtSpecular) {
  for (const double theta_i_deg : {0.0, 20.0, 60.0, 89.0}) {
    const auto wi = source_deg(theta_i_deg);
    const Vector3<double> ws(-wi.x(), -wi.y(), wi.z());
    EXPECT_EQ(brdf(one_term(test::stripes_term()), wi, ws), 300) << theta_i_deg;
  }
}

TEST(Stripes, AreContinuousThroughSpecular) {
  StripesTerm term = test::stripes_term();
  for (const double away : {1e-6, 1e-9, 1e-15, 1e-100, 1e-300}) {
    EXPECT_NEAR(brdf(one_term(term), source_deg(20), crest_stripes_along_x(20, away)), 300,
                300 * 2e7 * away * away + 1e-12);
  }
}

// The zeros of sinc² are where the path over one stripe's width is a whole number of waves.
TEST(StripesGrating, SincVanishesAtWholeWavesOverTheWidth) {
  StripesTerm term = fine_stripes(StripesForm::kGrating);
  term.b_m = 1e-5;
  const double zero = kWavelength_m / term.b_m;  // 63 mrad
  EXPECT_LE(brdf(one_term(term), source_deg(20), crest_stripes_along_x(20, zero)), 300 * 1e-20);
  EXPECT_GT(brdf(one_term(term), source_deg(20), crest_stripes_along_x(20, zero * 1.4)), 300 * 1e-3);
}

// exp(−(R hx)²/c²): one c/R of half-vector component along the stripes is a factor of e.
TEST(Stripes, FallByEOverTheirWidth) {
  const double width = 4e-5 / test::kDistance_m;
  const Vector3<double> wi(0, 0, 1), h(width, 0, std::sqrt(1 - width * width));
  const Vector3<double> ws = 2 * h.dot(wi) * h - wi;
  EXPECT_NEAR(brdf(one_term(test::stripes_term()), wi, ws), 300 * std::exp(-1), 1e-9 * 300);
}

}  // namespace
}  // namespace scatmap
