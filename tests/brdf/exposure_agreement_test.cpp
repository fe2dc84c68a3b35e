// Exposures of different scenes are found, those of one scene are not, whatever their factors. Does not prove where
// between them the line should lie.
#include "scatmap/brdf/exposure_agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace scatmap {
namespace {

// A lobe of `peak` DN/s seen through a factor, with noise of 3 DN/s and shot noise.
Counts seen(double peak, double factor, unsigned seed) {
  constexpr int kRows = 40, kColumns = 50;
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  Counts out{{kRows, kColumns},
             {kRows, kColumns, 9.f},
             {kRows, kColumns, 1.f},
             {kRows, kColumns, 0.f},
             {kRows, kColumns, Mask{0}},
             1.0,
             0,
             0};
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const double rate = peak / factor * std::exp(-(std::pow(r - 20, 2) + std::pow(c - 25, 2)) / 80);
      out.rate_dn_per_s(r, c) = rate + normal(rng) * std::sqrt(9 + rate);
      if (rate > 60000) out.mask(r, c) = kSaturated;
    }
  }
  return out;
}

TEST(ExposureAgreement, OneSceneThroughAnyFactor) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Counts a = seen(5e4, 1, seed), b = seen(5e4, 30, seed + 100), c = seen(5e4, 0.02, seed + 200);
    const std::vector<ScaledCounts> all{{&a, 1, 0}, {&b, 30, 0}, {&c, 0.02, 0}};
    EXPECT_FALSE(contradiction(all).has_value()) << seed;
  }
}

TEST(ExposureAgreement, AClosedShutterAndAForgottenFilterAreFound) {
  const Counts a = seen(5e4, 1, 1), b = seen(5e4, 30, 2), closed = seen(0, 1, 3), forgotten = seen(5e5, 30, 4);
  const auto dark = contradiction(std::vector<ScaledCounts>{{&a, 1, 0}, {&b, 30, 0}, {&closed, 0.02, 0}});
  ASSERT_TRUE(dark.has_value());
  EXPECT_EQ(dark->dim, 2u);
  EXPECT_LT(std::abs(dark->ratio), 0.01);
  const auto filter = contradiction(std::vector<ScaledCounts>{{&forgotten, 30, 0}, {&a, 1, 0}});
  ASSERT_TRUE(filter.has_value());
  EXPECT_EQ(filter->dim, 1u);
  EXPECT_EQ(filter->bright, 0u);
  EXPECT_NEAR(filter->ratio, 0.1, 0.01);
}

TEST(ExposureAgreement, WithoutLightThereIsNothingToSay) {
  const Counts a = seen(0, 1, 1), b = seen(0, 1, 2);
  EXPECT_FALSE(contradiction(std::vector<ScaledCounts>{{&a, 1, 0}, {&b, 1000, 0}}).has_value());
  EXPECT_FALSE(contradiction(std::vector<ScaledCounts>{{&a, 1, 0}}).has_value());
}

}  // namespace
}  // namespace scatmap
