// Residuals and the common scale on maps whose noise is known. Not proven here: that a map's stated uncertainties are
// the true ones.
#include "scatmap/compare/residual.h"

#include <gtest/gtest.h>

#include <limits>

#include "compare/synthetic_map.h"
#include "scatmap/base/error.h"

namespace scatmap {
namespace {

double field(double c, double r) { return 5 + synthetic::Lobe{40, 50, 200, 15}(c, r); }

TEST(Residual, ChiSquaredIsOneWhenTheModelIsTrue) {
  const BrdfMap model = synthetic::noiseless(200, 150, field);
  const Residual r = residual(synthetic::noisy(200, 150, field, 0.2, 0.5, 21), model);
  ASSERT_EQ(r.pixels, 30000u);
  const double spread = std::sqrt(2.0 / 30000);
  EXPECT_LE(std::abs(r.as_is.per_degree() - 1), 4 * spread);
  EXPECT_LE(std::abs(r.scaled.per_degree() - 1), 4 * spread);
  EXPECT_EQ(r.scaled.degrees_of_freedom, 29999);
  EXPECT_LE(r.scaled.sum, r.as_is.sum * (1 + 1e-12));
  double mean = 0;
  for (const float x : r.normalised) mean += static_cast<double>(x) / 30000;
  EXPECT_LE(std::abs(mean), 4 / std::sqrt(30000.0));
}

TEST(Residual, ScaleFactorAndItsStandardErrorByMonteCarlo) {
  const BrdfMap model = synthetic::noiseless(60, 60, field);
  constexpr int kTrials = 400;
  constexpr double kScale = 1.25;
  double sum = 0, square = 0, stated = 0;
  for (int t = 0; t < kTrials; ++t) {
    const auto scaled = [](double c, double r) { return kScale * field(c, r); };
    BrdfMap measured = synthetic::noisy(60, 60, scaled, 0.2, 0.5, 1000 + static_cast<unsigned>(t));
    // A structured cause weighs the pixels but is not in the random standard error.
    measured.structured.push_back({"U_TEST", "test", Grid<float>(60, 60, 1.0F)});
    const ScaleFit s = residual(measured, model).scale;
    sum += s.factor;
    square += s.factor * s.factor;
    stated += s.standard_error;
  }
  const double mean = sum / kTrials, scatter = std::sqrt(square / kTrials - mean * mean);
  EXPECT_LE(std::abs(mean - kScale), 4 * scatter / std::sqrt(kTrials));
  EXPECT_LE(std::abs(stated / kTrials / scatter - 1), 0.15);
}

TEST(Residual, PullIsAgainstTheStatedScale) {
  const BrdfMap model = synthetic::noiseless(60, 60, field);
  BrdfMap measured = synthetic::noisy(
      60, 60, [](double c, double r) { return 1.3 * field(c, r); }, 0.01, 0.05, 22);
  EXPECT_FALSE(residual(measured, model).scale.pull);
  measured.scale.causes.push_back({.name = "laser drift", .half_width = 0.15, .sensitivity = 1});
  const ScaleFit s = residual(measured, model).scale;
  ASSERT_TRUE(s.pull);
  EXPECT_LE(std::abs(*s.pull - 2), 0.02);
}

TEST(Residual, AllKindsOfUncertaintyOfBothMapsCombineButScaleDoesNot) {
  BrdfMap measured = synthetic::noiseless(10, 10, [](double, double) { return 17.0; });
  BrdfMap model = synthetic::noiseless(10, 10, [](double, double) { return 10.0; });
  measured.u_random_per_sr = Grid<float>(10, 10, 2.0F);
  measured.u_pose_per_sr = Grid<float>(10, 10, 3.0F);
  measured.structured.push_back({"U_A", "a", Grid<float>(10, 10, -4.0F)});
  model.structured.push_back({"U_B", "b", Grid<float>(10, 10, std::sqrt(20.0F))});
  measured.scale.causes.push_back({.name = "laser drift", .half_width = 0.5, .sensitivity = 1});
  const Residual r = residual(measured, model);
  EXPECT_FLOAT_EQ(r.normalised(3, 4), 1.0F);  // 7/sqrt(4 + 9 + 16 + 20)
  EXPECT_NEAR(r.as_is.per_degree(), 1, 1e-6);
}

TEST(Residual, MaskedAndNanPixelsAreLeftOut) {
  const BrdfMap model = synthetic::noiseless(50, 50, field);
  BrdfMap measured = synthetic::noisy(50, 50, field, 0.2, 0.5, 23);
  measured.brdf_per_sr(3, 4) = 1e9;
  measured.mask(3, 4) = kSaturated;
  measured.brdf_per_sr(5, 6) = std::numeric_limits<double>::quiet_NaN();
  measured.u_random_per_sr(7, 8) = 0;
  const Residual r = residual(measured, model);
  EXPECT_EQ(r.pixels, 2497u);
  EXPECT_TRUE(std::isnan(r.normalised(3, 4)));
  EXPECT_TRUE(std::isnan(r.normalised(5, 6)));
  EXPECT_TRUE(std::isnan(r.normalised(7, 8)));
  EXPECT_LE(r.as_is.per_degree(), 1.2);
  const Grid<float> ratio = log10_ratio(measured, model);
  EXPECT_TRUE(std::isnan(ratio(3, 4)));
  EXPECT_TRUE(std::isnan(ratio(5, 6)));
}

TEST(Residual, LogRatioIsDecimal) {
  const Grid<float> ratio = log10_ratio(synthetic::noiseless(4, 4, [](double, double) { return 100.0; }),
                                        synthetic::noiseless(4, 4, [](double c, double) { return c - 1; }));
  EXPECT_FLOAT_EQ(ratio(0, 2), 2.0F);
  EXPECT_TRUE(std::isnan(ratio(0, 0)));
  EXPECT_TRUE(std::isnan(ratio(0, 1)));
}

TEST(Residual, WhatCannotBeComparedIsAnError) {
  const BrdfMap a = synthetic::noisy(20, 20, field, 0.2, 0.5, 24);
  EXPECT_THROW(residual(a, synthetic::noiseless(20, 21, field)), Error);
  EXPECT_THROW(residual(synthetic::noiseless(20, 20, field), synthetic::noiseless(20, 20, field)), Error);
  BrdfMap masked = a;
  for (Mask& m : masked.mask) m = kNoData;
  EXPECT_THROW(residual(masked, synthetic::noiseless(20, 20, field)), Error);
}

}  // namespace
}  // namespace scatmap
