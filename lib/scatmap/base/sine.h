#pragma once
#include "scatmap/base/simd.h"

namespace scatmap {

/// Relative error of sin_pi_kernel against long double, for |x| <= 1/2, apart from the rounding of x itself.
inline constexpr double kSineError = 6e-16;
inline constexpr double kSineSingleError = 4e-7;

/// x less the nearest integer, in [−1/2, 1/2]; exact. |x| < 2^51; NaN for NaN.
SCATMAP_INLINE double beside_integer(double x) {
  constexpr double kRound = 0x1.8p52;
  return x - ((x + kRound) - kRound);
}

/// sin(pi x) for |x| <= 1/2 without a branch or a call, so that loops over it vectorise: Taylor's series, whose
/// remainder is below 1e-18 (double) and 6e-9 (float). NaN for NaN.
SCATMAP_INLINE double sin_pi_kernel(double x) {
  constexpr double kPi = 3.141592653589793;
  const double y = kPi * x, z = y * y;
  double p = 1.0 / 51090942171709440000.0;
  p = 1.0 / -121645100408832000.0 + p * z;
  p = 1.0 / 355687428096000.0 + p * z;
  p = 1.0 / -1307674368000.0 + p * z;
  p = 1.0 / 6227020800.0 + p * z;
  p = 1.0 / -39916800.0 + p * z;
  p = 1.0 / 362880.0 + p * z;
  p = 1.0 / -5040.0 + p * z;
  p = 1.0 / 120.0 + p * z;
  p = 1.0 / -6.0 + p * z;
  return y + y * (z * p);
}

SCATMAP_INLINE float sin_pi_kernel(float x) {
  constexpr float kPi = 3.14159274f;
  const float y = kPi * x, z = y * y;
  float p = 1.0f / 6227020800.0f;
  p = 1.0f / -39916800.0f + p * z;
  p = 1.0f / 362880.0f + p * z;
  p = 1.0f / -5040.0f + p * z;
  p = 1.0f / 120.0f + p * z;
  p = 1.0f / -6.0f + p * z;
  return y + y * (z * p);
}

}  // namespace scatmap
