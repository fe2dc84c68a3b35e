#pragma once
#include <bit>
#include <cstdint>

#include "scatmap/base/simd.h"

namespace scatmap {

/// Below this the kernels' exponential is exactly 0: the smallest argument whose result keeps all its digits.
inline constexpr double kSmallestExponent = -708.0;

/// Relative error of exp_kernel<double> and exp_kernel<float> against long double, for kSmallestExponent <= x <= 0.
inline constexpr double kExponentialError = 4e-16;
inline constexpr double kExponentialSingleError = 3e-7;

namespace detail {

// exp of |r| <= ln(2)/2: Taylor's series, whose remainder there is below 5e-18 (double) and 6e-9 (float).
SCATMAP_INLINE double exp_reduced(double r) {
  double p = 1.0 / 6227020800.0;
  p = p * r + 1.0 / 479001600.0;
  p = p * r + 1.0 / 39916800.0;
  p = p * r + 1.0 / 3628800.0;
  p = p * r + 1.0 / 362880.0;
  p = p * r + 1.0 / 40320.0;
  p = p * r + 1.0 / 5040.0;
  p = p * r + 1.0 / 720.0;
  p = p * r + 1.0 / 120.0;
  p = p * r + 1.0 / 24.0;
  p = p * r + 1.0 / 6.0;
  p = p * r + 0.5;
  return 1.0 + (r + r * r * p);
}

SCATMAP_INLINE float exp_reduced(float r) {
  float p = 1.0f / 5040.0f;
  p = p * r + 1.0f / 720.0f;
  p = p * r + 1.0f / 120.0f;
  p = p * r + 1.0f / 24.0f;
  p = p * r + 1.0f / 6.0f;
  p = p * r + 0.5f;
  return 1.0f + (r + r * r * p);
}

}  // namespace detail

/// exp(x) for x <= 0 without a branch or a call, so that loops over it vectorise; 0 for x < kSmallestExponent, NaN for
/// NaN. The argument is reduced in double in both; T is the type of the polynomial alone.
template <class T>
SCATMAP_INLINE double exp_kernel(double x) {
  constexpr double kPerLn2 = 1.4426950408889634, kLn2High = 0x1.62e42fefa3800p-1, kLn2Low = 0x1.ef35793c76730p-45;
  constexpr double kRound = 0x1.8p52;  // adding it leaves the nearest integer in the low bits
  const double clamped = x < kSmallestExponent ? kSmallestExponent : x;
  const double shifted = clamped * kPerLn2 + kRound;
  const double n = shifted - kRound;
  const double r = (clamped - n * kLn2High) - n * kLn2Low;
  const double power = std::bit_cast<double>((std::bit_cast<std::uint64_t>(shifted) + 1023) << 52);  // 2^n
  const double value = static_cast<double>(detail::exp_reduced(static_cast<T>(r))) * power;
  return x < kSmallestExponent ? 0.0 : value;
}

}  // namespace scatmap
