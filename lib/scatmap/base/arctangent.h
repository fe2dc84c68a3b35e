#pragma once
#include "scatmap/base/simd.h"

/// Arctangents for loops that the compiler vectorises: no branch, no table, every callee inlined. Double or float.
namespace scatmap {

/// Largest |t| of small_arctangent.
inline constexpr double kSmallArctangentRange = 0.125;
/// Truncation of the polynomials, rad; rounding, 2 ulp of the result, comes on top.
inline constexpr double kArctangentTruncation = 4e-18;
inline constexpr double kArctangentTruncationSingle = 1.2e-9;

/// Coefficients of (atan(t)/t − 1)/t² in powers of t²: interpolation at Chebyshev's points in 60 digits.
template <class T>
struct ArctangentCoefficients;

template <>
struct ArctangentCoefficients<double> {
  static constexpr double kSmall[] = {-0.33333333333333287, 0.19999999999790477,  -0.14285714129116034,
                                      0.1111106826170422,   -0.09085599506798686, 0.07387718384425714};
  static constexpr double kEighth[] = {-0.3333333333333333,  0.19999999999995516,  -0.14285714284665682,
                                       0.11111111015187018,  -0.0909090457530649,  0.07692183125376892,
                                       -0.06664510525508936, 0.05858140904866328,  -0.050854078345894844,
                                       0.03923044778479309,  -0.019175404711104935};
  // pi/4 in two parts; the first has 48 bits, so that up to 8 times it is exact.
  static constexpr double kQuarterPi = 0x1.921fb54442d0p-1;
  static constexpr double kQuarterPiRest = 0x1.8469898cc51701b839a2p-49;
};

template <>
struct ArctangentCoefficients<float> {
  static constexpr float kSmall[] = {-0.3333333134651184f, 0.19998501241207123f, -0.14028993248939514f};
  static constexpr float kEighth[] = {-0.3333333134651184f, 0.19999539852142334f, -0.14263950288295746f,
                                      0.10743668675422668f, -0.06451718509197235f};
  static constexpr float kQuarterPi = 0x1.921f80p-1f;
  static constexpr float kQuarterPiRest = 0x1.aa2216p-20f;
};

template <class T, int N>
SCATMAP_INLINE T polynomial(const T (&coefficients)[N], T x) {
  T sum = coefficients[N - 1];
  for (int k = N - 2; k >= 0; --k) sum = sum * x + coefficients[k];
  return sum;
}

/// atan(t), |t| <= kSmallArctangentRange.
template <class T>
SCATMAP_INLINE T small_arctangent(T t) {
  const T t2 = t * t;
  return t + t * t2 * polynomial(ArctangentCoefficients<T>::kSmall, t2);
}

/// An angle as eighths·pi/4 + rest: turns can be added to it without rounding.
template <class T>
struct EighthTurns {
  T eighths;
  T rest;

  SCATMAP_INLINE T radians() const {
    return eighths * ArctangentCoefficients<T>::kQuarterPi +
           (eighths * ArctangentCoefficients<T>::kQuarterPiRest + rest);
  }
};

/// atan2(y, x) for x >= 0 and y >= 0, in [0, pi/2]; 0 where both are 0. NaN in, NaN out.
template <class T>
SCATMAP_INLINE EighthTurns<T> quadrant_arctangent(T y, T x) {
  constexpr T kTanPi8 = T(0.41421356237309503);
  const bool steep = y > x;
  const T larger = steep ? y : x, smaller = steep ? x : y;
  const bool diagonal = smaller > kTanPi8 * larger;  // within pi/8 of pi/4: atan(q) = pi/4 + atan((q − 1)/(q + 1))
  const T numerator = diagonal ? smaller - larger : smaller;
  const T sum = diagonal ? smaller + larger : larger;
  const T t = numerator / (sum == 0 ? T(1) : sum);
  const T t2 = t * t;
  const T angle = t + t * t2 * polynomial(ArctangentCoefficients<T>::kEighth, t2);
  return {diagonal ? T(1) : (steep ? T(2) : T(0)), steep ? -angle : angle};
}

/// Azimuth from −x towards −y, in [0, 2 pi): the branch-free azimuth_from_minus_x (base/direction.h).
template <class T>
SCATMAP_INLINE T azimuth_from_minus_x(T x, T y) {
  constexpr T kTwoPi = T(6.283185307179586476925286766559);
  const EighthTurns<T> folded = quadrant_arctangent(y < 0 ? -y : y, x < 0 ? -x : x);
  const bool left = x < 0, below = y < 0;
  const T from = left ? (below ? T(0) : T(8)) : T(4);
  const bool forwards = left == below;
  const EighthTurns<T> turned{forwards ? from + folded.eighths : from - folded.eighths,
                              forwards ? folded.rest : -folded.rest};
  const T phi = turned.radians();
  return phi >= kTwoPi || phi < 0 ? T(0) : phi;
}

}  // namespace scatmap
