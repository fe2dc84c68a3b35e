// The kernels' exponential and sine against libm in long double over their whole domains. Not proven: every double (a
// grid and random arguments are taken), nor that loops over them are vectorised (the benchmarks show it).
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "scatmap/base/exponential.h"
#include "scatmap/base/sine.h"

namespace scatmap {
namespace {

using Long = long double;

TEST(ExpKernel, KeepsItsError) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> log_x(std::log(1e-18), std::log(-kSmallestExponent));
  double worst = 0, worst_single = 0;
  for (int i = 0; i < 1000000; ++i) {
    const double x = std::max(-std::exp(log_x(random)), kSmallestExponent);
    const Long truth = std::exp(Long(x));
    worst = std::max(worst, static_cast<double>(std::abs(exp_kernel<double>(x) / truth - 1)));
    worst_single = std::max(worst_single, static_cast<double>(std::abs(exp_kernel<float>(x) / truth - 1)));
  }
  EXPECT_LE(worst, kExponentialError);
  EXPECT_LE(worst_single, kExponentialSingleError);
  EXPECT_GT(worst_single, 1e-9);  // or it was double after all
}

TEST(ExpKernel, EndsOfItsDomain) {
  EXPECT_EQ(exp_kernel<double>(0), 1);
  EXPECT_EQ(exp_kernel<float>(-0.0), 1);
  EXPECT_GT(exp_kernel<double>(kSmallestExponent), 0);
  EXPECT_EQ(exp_kernel<double>(-708.0001), 0);
  EXPECT_EQ(exp_kernel<double>(-HUGE_VAL), 0);
  EXPECT_EQ(exp_kernel<float>(-1e300), 0);
  EXPECT_TRUE(std::isnan(exp_kernel<double>(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_TRUE(std::isnan(exp_kernel<float>(std::numeric_limits<double>::quiet_NaN())));
}

TEST(SinPiKernel, KeepsItsError) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> log_x(std::log(1e-30), std::log(0.5));
  double worst = 0, worst_single = 0;
  for (int i = 0; i < 1000000; ++i) {
    const double x = std::exp(log_x(random)) * (i % 2 == 0 ? 1 : -1);
    const Long pi = std::numbers::pi_v<Long>;
    worst = std::max(worst, static_cast<double>(std::abs(sin_pi_kernel(x) / std::sin(pi * Long(x)) - 1)));
    const auto single = static_cast<float>(x);
    const Long error = sin_pi_kernel(single) / std::sin(pi * Long(single)) - 1;
    worst_single = std::max(worst_single, static_cast<double>(std::abs(error)));
  }
  EXPECT_LE(worst, kSineError);
  EXPECT_LE(worst_single, kSineSingleError);
  EXPECT_TRUE(std::isnan(sin_pi_kernel(std::numeric_limits<double>::quiet_NaN())));
}

TEST(BesideInteger, IsExact) {
  for (const double x : {0.0, 0.25, -0.25, 0.49999999999999994, 12345.75, -1e9 - 0.25, 4503599627370495.5 / 8}) {
    EXPECT_EQ(beside_integer(x), std::remainder(x, 1.0)) << x;
  }
}

}  // namespace
}  // namespace scatmap
