// Statistics of the scale against closed forms: one rectangular density (log-uniform), one normal (lognormal), two
// equal rectangulars (triangular), and the moments of their products; and what the first-order statement is worth at
// the paper's 59.3 %. Does not prove that a filter's error is rectangular: that is the user's statement.
#include "scatmap/brdf/scale_statistics.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "scatmap/base/units.h"

namespace scatmap {
namespace {

ScaleCause filter(double half_width_od, Distribution d = Distribution::kRectangular, double below = 0) {
  return {"filter", d, half_width_od, kLn10, true, below};
}

ScaleBudget one(const ScaleCause& c) { return {{c}, {}}; }

// The paper's 20 deg case (design, section 2) and its four other filters as the shipped scenes have them.
ScaleBudget paper_case() {
  ScaleBudget b;
  for (const double od : {3.0, 0.3})
    b.causes.push_back({"sample", Distribution::kRectangular, 0.05 * od, kLn10, true, 0});
  for (const double od : {4.0, 1.0, 0.6, 0.3, 0.1694})
    b.causes.push_back({"signature", Distribution::kRectangular, 0.05 * od, -kLn10, true, 0});
  return b;
}

TEST(ScaleStatistics, MomentsOfOneRectangularAreThoseOfTheLogUniformDensity) {
  const double d = 0.2575, a = std::pow(10, -d), b = std::pow(10, d), ln = std::log(b / a);
  const double mean = (b - a) / ln, square = (b * b - a * a) / (2 * ln);
  const FactorMoments m = exact_moments(one(filter(d)));
  EXPECT_NEAR(m.mean, mean, 1e-14);
  EXPECT_NEAR(m.sd, std::sqrt(square - mean * mean), 1e-13);
}

// The densities' exponential moments by Simpson's rule, as independent of the closed forms as can be.
double integral(const ScaleCause& c, int power) {
  const double low = c.distribution == Distribution::kAsymmetric ? -c.half_width_below : -c.half_width,
               high = c.half_width;
  const auto density = [&](double x) {
    return c.distribution == Distribution::kTriangular ? (1 - std::abs(x) / high) / high : 1 / (high - low);
  };
  constexpr int kSteps = 20000;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = low + (high - low) * i / kSteps;
    sum += (i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2) * density(x) * std::exp(power * c.sensitivity * x);
  }
  return sum * (high - low) / kSteps / 3;
}

TEST(ScaleStatistics, MomentsOfTriangularAndAsymmetric) {
  for (const ScaleCause& c : {filter(0.3, Distribution::kTriangular), filter(0.3, Distribution::kAsymmetric, 0.1),
                              filter(0.1, Distribution::kAsymmetric, 0.4)}) {
    const FactorMoments m = exact_moments(one(c));
    EXPECT_NEAR(m.mean, integral(c, 1), 1e-10);
    EXPECT_NEAR(m.sd * m.sd + m.mean * m.mean, integral(c, 2), 1e-10);
    const FactorStatistics mc = monte_carlo(one(c), 0, 1'000'000);
    EXPECT_NEAR(mc.mean, m.mean, 5 * m.sd / 1000);
    EXPECT_NEAR(mc.sd, m.sd, 5 * m.sd / 1000);
  }
}

TEST(ScaleStatistics, NormalCausesAreLognormalWithTheirCorrelation) {
  ScaleBudget b;
  b.causes = {{"filter a", Distribution::kNormal, 0.05, kLn10, true, 0},
              {"filter b", Distribution::kNormal, 0.08, -kLn10, true, 0}};
  b.correlation = Eigen::MatrixXd::Identity(2, 2);
  b.correlation(0, 1) = b.correlation(1, 0) = 0.9;
  const double variance = kLn10 * kLn10 * (0.05 * 0.05 + 0.08 * 0.08 - 2 * 0.9 * 0.05 * 0.08);
  EXPECT_NEAR(b.standard(), std::sqrt(variance), 1e-15);
  EXPECT_NEAR(exact_moments(b).mean, std::exp(variance / 2), 1e-14);
  const FactorStatistics exact = lognormal(b), mc = monte_carlo(b, 0, 2'000'000);
  EXPECT_NEAR(mc.symmetric.low, exact.symmetric.low, 5e-4);
  EXPECT_NEAR(mc.symmetric.high, exact.symmetric.high, 5e-4);
  EXPECT_NEAR(std::log(exact.symmetric.high), 1.959963984540054 * std::sqrt(variance), 1e-12);
  // Equal densities at both ends make an interval the shortest one.
  const auto density = [&](double f) { return std::exp(-std::log(f) * std::log(f) / (2 * variance)) / f; };
  EXPECT_NEAR(density(exact.shortest.low) / density(exact.shortest.high), 1, 1e-12);
  const auto below = [&](double f) { return 0.5 * std::erfc(-std::log(f) / std::sqrt(2 * variance)); };
  EXPECT_NEAR(below(exact.shortest.high) - below(exact.shortest.low), 0.95, 1e-14);
  EXPECT_NEAR(mc.shortest.low, exact.shortest.low, 5e-3);
}

TEST(ScaleStatistics, MonteCarloQuantilesOfOneAndTwoRectangulars) {
  const double d = 0.2575;
  const FactorStatistics r = monte_carlo(one(filter(d)), 0, 4'000'000);
  EXPECT_NEAR(r.symmetric.low, std::pow(10, -0.95 * d), 1e-3);
  EXPECT_NEAR(r.symmetric.high, std::pow(10, 0.95 * d), 1e-3);
  EXPECT_NEAR(r.shortest.low, std::pow(10, -d), 2e-3);
  EXPECT_NEAR(r.shortest.high, std::pow(10, 0.9 * d), 2e-3);
  ScaleBudget two{{filter(d), filter(d)}, {}};
  two.causes[1].sensitivity *= -1;
  const double triangular = 2 * d * (1 - std::sqrt(0.05));  // 97.5 % of a triangle of half width 2d
  const FactorStatistics t = monte_carlo(two, 0, 4'000'000);
  EXPECT_NEAR(t.symmetric.high, std::pow(10, triangular), 2e-3);
  EXPECT_NEAR(t.symmetric.low, std::pow(10, -triangular), 1e-3);
}

TEST(ScaleStatistics, PixelNoiseMultiplies) {
  const FactorMoments m = exact_moments(one(filter(0.1)), 0.2);
  const FactorStatistics mc = monte_carlo(one(filter(0.1)), 0.2, 4'000'000);
  EXPECT_NEAR(mc.mean, m.mean, 1e-3);
  EXPECT_NEAR(mc.sd, m.sd, 1e-3);
  EXPECT_NEAR(monte_carlo({}, 0.2, 4'000'000).symmetric.high, 1 + 0.2 * 1.95996, 1e-3);
}

// Numbers of the paper's two cases, computed once by numpy with 8e6 trials: mean 1.060, sd 0.3665, 95 % [0.523, 1.910].
TEST(ScaleStatistics, ThePapersWorstCaseAndWhyFirstOrderFails) {
  const ScaleBudget b = paper_case();
  EXPECT_NEAR(100 * b.filters_worst_case(), 59.3, 0.05);
  EXPECT_NEAR(b.filters_linear_bound(), kLn10 * 0.05 * (3.3 + 6.0694), 1e-12);
  EXPECT_NEAR(b.standard(), 0.3426, 2e-4);
  EXPECT_NEAR(exact_moments(b).mean, 1.060, 5e-4);
  EXPECT_NEAR(exact_moments(b).sd, 0.3665, 5e-4);
  const FirstOrderVerdict v = check_first_order(b, 0, 1);
  EXPECT_EQ(v.delta, 0.05);
  EXPECT_FALSE(v.valid);
  EXPECT_TRUE(v.monte_carlo.converged);
  EXPECT_NEAR(v.monte_carlo.factor.symmetric.low, 0.523, 0.005);
  EXPECT_NEAR(v.monte_carlo.factor.symmetric.high, 1.910, 0.01);
  EXPECT_NEAR(second_order(one({"x", Distribution::kNormal, 0.3424, 1, false, 0})).sd, 0.3712, 2e-4);
  ScaleBudget shared;
  shared.causes = {filter(0.05), filter(0.03), filter(0.015), filter(0.00847)};
  EXPECT_NEAR(100 * shared.filters_worst_case(), 14.0, 0.05);
  EXPECT_FALSE(check_first_order(shared, 0, 2).valid);
  EXPECT_TRUE(check_first_order(one({"x", Distribution::kNormal, 0.003, 1, false, 0}), 0, 1).valid);
}

// Coverage of what each method says at 59.3 %, counted with other random numbers.
TEST(ScaleStatistics, CoverageOfTheMonteCarloIntervalIs95PerCent) {
  const ScaleBudget b = paper_case();
  const FactorStatistics mc = monte_carlo(b, 0, 1'000'000, 1);
  constexpr int kSets = 40;  // of intervals of an independent run: its tails must hold 2.5 % each
  double low = 0, high = 0;
  for (std::uint64_t s = 0; s < kSets; ++s) {
    const FactorStatistics other = monte_carlo(b, 0, 100'000, 100 + s);
    low += other.symmetric.low / kSets;
    high += other.symmetric.high / kSets;
  }
  EXPECT_NEAR(low / mc.symmetric.low, 1, 2e-3);
  EXPECT_NEAR(high / mc.symmetric.high, 1, 2e-3);
  const FactorStatistics guf = first_order(b);
  EXPECT_GT(mc.symmetric.high - guf.symmetric.high, 0.2);  // first order misses on the high side
}

TEST(ScaleStatistics, ToleranceOfTheStandard) {
  EXPECT_NEAR(numerical_tolerance(0.3424, 1), 0.05, 1e-15);
  EXPECT_NEAR(numerical_tolerance(0.3424, 2), 0.005, 1e-15);
  EXPECT_NEAR(numerical_tolerance(0.0961, 1), 0.05, 1e-15);  // 0.1 with one digit
  EXPECT_NEAR(numerical_tolerance(0.0808, 1), 0.005, 1e-15);
}

TEST(ScaleStatistics, AdaptiveRunMeetsItsToleranceAgainstTheClosedForm) {
  const AdaptiveResult a = adaptive_monte_carlo(one(filter(0.2575)), 0, 0.001);
  EXPECT_TRUE(a.converged);
  EXPECT_NEAR(a.factor.symmetric.low, std::pow(10, -0.95 * 0.2575), 0.0015);
  EXPECT_NEAR(a.factor.symmetric.high, std::pow(10, 0.95 * 0.2575), 0.0015);
  EXPECT_TRUE(adaptive_monte_carlo({}, 0, 0.001).converged);
}

TEST(ScaleStatistics, TwelveMillionTrialsOfEightInputsAreQuick) {
  ScaleBudget b = paper_case();
  b.causes.push_back({"laser drift", Distribution::kRectangular, 0.005, 1, false, 0});
  b.causes.push_back({"signature", Distribution::kNormal, 0.001, -1, false, 0});
  const auto start = std::chrono::steady_clock::now();
  const FactorStatistics s = monte_carlo(b, 0, 12'000'000);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("1.2e7 trials, %zu inputs: %.3f s\n", b.causes.size(), seconds);
  EXPECT_NEAR(s.sd, exact_moments(b).sd, 1e-3);
  EXPECT_LE(seconds, 5.0);  // the bar is 1 s on a free machine
}

// A cause of 200 %: the standard deviation of F is 54, its lower end 0.02.
TEST(ScaleStatistics, MonteCarloResolvesTheLowerEndOfWideFactors) {
  const ScaleBudget wide{{{"gain", Distribution::kNormal, 2, 1, false, 0}}, {}};
  const FactorStatistics f = monte_carlo(wide, 0, 1'000'000);
  EXPECT_NEAR(std::log(f.symmetric.low), -2 * 1.959964, 0.02);
  EXPECT_NEAR(std::log(f.symmetric.high), 2 * 1.959964, 0.02);
  const FactorStatistics with_noise = monte_carlo(wide, 0.5, 1'000'000);  // one in forty is negative
  EXPECT_NEAR(with_noise.symmetric.low, 0, 0.005);
}

}  // namespace
}  // namespace scatmap
