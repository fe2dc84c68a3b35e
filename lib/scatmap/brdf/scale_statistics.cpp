#include "scatmap/brdf/scale_statistics.h"

#include <algorithm>
#include <cmath>

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

// Shortest interval of a lognormal: equal densities at both ends; the lower tail p in (0, 5 %) by golden section.
FactorInterval shortest_lognormal(double shift, double u) {
  const auto quantile = [](double p) {  // of the standard normal, by bisection: 60 steps are exact
    double low = -9, high = 9;
    for (int i = 0; i < 60; ++i) {
      const double mid = 0.5 * (low + high);
      (0.5 * std::erfc(-mid / std::sqrt(2.0)) < p ? low : high) = mid;
    }
    return 0.5 * (low + high);
  };
  const auto interval = [&](double p) {
    return FactorInterval{std::exp(shift + u * quantile(p)), std::exp(shift + u * quantile(p + 0.95))};
  };
  const auto width = [&](double p) { return interval(p).high - interval(p).low; };
  constexpr double kGolden = 0.6180339887498949;
  double a = 1e-9, b = 0.05 - 1e-9;
  for (int i = 0; i < 60; ++i) {
    const double left = b - kGolden * (b - a), right = a + kGolden * (b - a);
    (width(left) < width(right) ? b : a) = width(left) < width(right) ? right : left;
  }
  return interval(0.5 * (a + b));
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
