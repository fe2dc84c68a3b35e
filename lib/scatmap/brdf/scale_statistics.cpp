#include "scatmap/brdf/scale_statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace scatmap {
namespace {

constexpr double kNormal95 = 1.959963984540054;  // Φ^-1(0.975)

double sinh_over(double x) { return std::abs(x) < 1e-6 ? 1 + x * x / 6 : std::sinh(x) / x; }

// E exp(x X/half width of X) of the causes that are not normal; x = k·sensitivity·half width.
double moment(const ScaleCause& c, double k) {
  const double x = k * c.sensitivity * c.half_width;
  switch (c.distribution) {
    case Distribution::kRectangular:
      return sinh_over(x);
    case Distribution::kTriangular:
      return sinh_over(x / 2) * sinh_over(x / 2);
    case Distribution::kAsymmetric: {
      const double below = k * c.sensitivity * c.half_width_below;
      return std::exp((x - below) / 2) * sinh_over((x + below) / 2);
    }
    case Distribution::kNormal:
      break;
  }
  return 1;
}

double normal_variance(const ScaleBudget& budget) {
  ScaleBudget normals = budget;
  for (ScaleCause& c : normals.causes) {
    if (c.distribution != Distribution::kNormal) c.sensitivity = 0;
  }
  const double u = normals.standard();
  return u * u;
}

// Mean of ln F: not 0 only for asymmetric causes.
double shift_of(const ScaleBudget& budget) {
  double sum = 0;
  for (const ScaleCause& c : budget.causes) {
    if (c.distribution == Distribution::kAsymmetric) sum += c.sensitivity * (c.half_width - c.half_width_below) / 2;
  }
  return sum;
}

double normal_below(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }
double normal_density(double z) { return std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi); }

// Shortest interval of a lognormal: its ends have equal densities, which makes them exp(−u² ± u t) about the shift;
// t by Newton's method from Φ(t − u) − Φ(−t − u) = 0.95.
FactorInterval shortest_lognormal(double shift, double u) {
  double t = kNormal95;
  constexpr int kSteps = 20;  // 5 are enough for u of 1
  for (int i = 0; i < kSteps; ++i) {
    const double miss = normal_below(t - u) - normal_below(-t - u) - 0.95;
    t -= miss / (normal_density(t - u) + normal_density(t + u));
    if (std::abs(miss) < 1e-15) break;
  }
  return {std::exp(shift - u * (u + t)), std::exp(shift - u * (u - t))};
}

}  // namespace

double decibel(double factor) { return 10 * std::log10(factor); }

FactorMoments exact_moments(const ScaleBudget& budget, double relative_normal) {
  const double normal = normal_variance(budget);
  double first = std::exp(normal / 2), second = std::exp(2 * normal);
  for (const ScaleCause& c : budget.causes) {
    first *= moment(c, 1);
    second *= moment(c, 2);
  }
  second *= 1 + relative_normal * relative_normal;
  return {first, std::sqrt(std::max(0.0, second - first * first))};
}

FactorStatistics first_order(const ScaleBudget& budget, double relative_normal) {
  const double u = std::hypot(budget.standard(), relative_normal);
  const FactorInterval interval{1 - kNormal95 * u, 1 + kNormal95 * u};
  return {1, u, interval, interval};
}

FactorStatistics second_order(const ScaleBudget& budget, double relative_normal) {
  const double u2 = budget.standard() * budget.standard();
  const double mean = 1 + shift_of(budget) + u2 / 2;
  const double u = std::sqrt(u2 + 1.5 * u2 * u2 + relative_normal * relative_normal);
  const FactorInterval interval{mean - kNormal95 * u, mean + kNormal95 * u};
  return {mean, u, interval, interval};
}

FactorStatistics lognormal(const ScaleBudget& budget, double relative_normal) {
  const double u = std::hypot(budget.standard(), relative_normal), shift = shift_of(budget);
  const double mean = std::exp(shift + u * u / 2);
  FactorStatistics out{mean,
                       mean * std::sqrt(std::expm1(u * u)),
                       {std::exp(shift - kNormal95 * u), std::exp(shift + kNormal95 * u)},
                       {}};
  out.shortest = u > 0 ? shortest_lognormal(shift, u) : out.symmetric;
  return out;
}

double numerical_tolerance(double u, int digits) {
  if (!(u > 0)) return 0;
  // u = c × 10^l with c a whole number of `digits` digits, u rounded to it first: 0.096 with one digit is 1 × 10^-1.
  double power = std::floor(std::log10(u)) - digits + 1;
  if (std::round(u / std::pow(10, power)) >= std::pow(10, digits)) power += 1;
  return 0.5 * std::pow(10, power);
}

FirstOrderVerdict check_first_order(const ScaleBudget& budget, double relative_normal, int digits) {
  FirstOrderVerdict out;
  const FactorStatistics guf = first_order(budget, relative_normal);
  out.delta = numerical_tolerance(guf.sd, digits);
  if (!(out.delta > 0)) return out;
  out.monte_carlo = adaptive_monte_carlo(budget, relative_normal, out.delta / 5);
  out.d_low = std::abs(guf.symmetric.low - out.monte_carlo.factor.symmetric.low);
  out.d_high = std::abs(guf.symmetric.high - out.monte_carlo.factor.symmetric.high);
  out.valid = out.d_low <= out.delta && out.d_high <= out.delta;
  return out;
}

}  // namespace scatmap
