#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>

#include "scatmap/brdf/scale.h"

namespace scatmap {

/// Statistics of the factor F by which the true BRDF may differ from the reported one:
///   F = exp(Σ sensitivity_i X_i) · (1 + r Z),
/// X_i the causes of a scale budget (filters: exactly 10^±X; a relative cause x acts as exp(±x), equal to 1 ± x to
/// first order), Z standard normal and r the relative standard uncertainty of one pixel or region without the scale (0:
/// the scale alone). The reported value is F = 1.
struct FactorInterval {
  double low = 1, high = 1;  ///< factors on the reported value
};
/// 10·log10 of a factor.
double decibel(double factor);

struct FactorStatistics {
  double mean = 1, sd = 0;
  FactorInterval symmetric;  ///< 95 %: 2.5 % of probability on either side
  FactorInterval shortest;   ///< the shortest interval of 95 %
};

struct FactorMoments {
  double mean = 1, sd = 0;
};

/// Exact: a rectangular cause gives E F^k = sinh(k s d)/(k s d), a normal one exp((k s σ)²/2), a triangular one the
/// square of the rectangular of half its width; correlated causes are normal together.
FactorMoments exact_moments(const ScaleBudget& budget, double relative_normal = 0);

/// GUM (JCGM 100): 1 ± 1.96 u.
FactorStatistics first_order(const ScaleBudget& budget, double relative_normal = 0);
/// GUM 5.1.2 with the next terms of the Taylor series for normal causes: mean 1 + u²/2, variance u² + 3/2 u⁴.
FactorStatistics second_order(const ScaleBudget& budget, double relative_normal = 0);
/// ln F taken as normal: exact for the scale when all its causes are normal.
FactorStatistics lognormal(const ScaleBudget& budget, double relative_normal = 0);

inline constexpr std::uint64_t kScaleSeed = 20211;  // any number; fixed, so that a map has one answer
/// Monte Carlo of JCGM 101 with a counter-based generator (SplitMix64 on the trial's number): the same result at any
/// number of threads. Quantiles come from a histogram whose bin is below 1e-3 standard deviations.
FactorStatistics monte_carlo(const ScaleBudget& budget, double relative_normal, std::size_t trials,
                             std::uint64_t seed = kScaleSeed);

struct AdaptiveResult {
  FactorStatistics factor;
  std::size_t trials = 0;
  double tolerance = 0;    ///< twice the standard deviation of mean, sd and both ends is below it
  bool converged = false;  ///< within kMostTrials
};
inline constexpr std::size_t kMostTrials = 40'000'000;

/// Numerical tolerance of JCGM 101, 7.9.2: half a unit of the last of `digits` significant digits of u.
double numerical_tolerance(double u, int digits);
/// JCGM 101, 7.9: blocks of 10^4 trials until mean, standard deviation and the ends of the 95 % interval are stable.
AdaptiveResult adaptive_monte_carlo(const ScaleBudget& budget, double relative_normal, double tolerance,
                                    std::uint64_t seed = kScaleSeed);

/// JCGM 101, clause 8: is 1 ± 1.96 u good enough?
struct FirstOrderVerdict {
  double d_low = 0, d_high = 0;  ///< distances between the ends of the two 95 % intervals
  double delta = 0;              ///< numerical tolerance of u; both must be within it
  bool valid = true;
  AdaptiveResult monte_carlo;  ///< run to delta/5
};
/// @param digits significant digits of u that the first-order statement claims: 1 or 2
FirstOrderVerdict check_first_order(const ScaleBudget& budget, double relative_normal = 0, int digits = 1);

}  // namespace scatmap
