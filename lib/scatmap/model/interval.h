#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

namespace scatmap {

/// Numbers between two bounds. Every operation returns an interval that holds each exact result of any two members: the
/// rounding of its own bounds is outward by at least an ulp. What cannot be bounded is (−inf, inf).
struct Interval {
  double low = 0;
  double high = 0;

  Interval() = default;
  Interval(double v) : low(v), high(v) {}  // NOLINT(google-explicit-constructor): a number is an interval
  Interval(double l, double h) : low(l), high(h) {}

  static Interval everything() { return {-HUGE_VAL, HUGE_VAL}; }
  bool bounded() const { return low > -HUGE_VAL && high < HUGE_VAL; }
  double magnitude() const { return std::max(std::abs(low), std::abs(high)); }
  double width() const { return high - low; }
  bool contains(double v) const { return low <= v && v <= high; }
};

/// Bounds computed with rounding to nearest, moved outward by more than their rounding (two ulp, and the smallest
/// normal number for results that underflow). A NaN on the way (inf − inf, 0·inf) makes the interval everything.
inline Interval outward(double low, double high) {
  constexpr double kTwoUlp = 2 * std::numeric_limits<double>::epsilon();
  constexpr double kTiny = std::numeric_limits<double>::min();
  const double l = low - std::abs(low) * kTwoUlp - kTiny, h = high + std::abs(high) * kTwoUlp + kTiny;
  return l <= h ? Interval(l, h) : Interval::everything();
}

inline Interval operator-(const Interval& a) { return {-a.high, -a.low}; }
inline Interval operator+(const Interval& a, const Interval& b) { return outward(a.low + b.low, a.high + b.high); }
inline Interval operator-(const Interval& a, const Interval& b) { return outward(a.low - b.high, a.high - b.low); }

inline Interval operator*(const Interval& a, const Interval& b) {
  const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
  if (std::isnan(p + q + r + s)) return Interval::everything();
  return outward(std::min(std::min(p, q), std::min(r, s)), std::max(std::max(p, q), std::max(r, s)));
}

inline Interval operator/(const Interval& a, const Interval& b) {
  if (!(b.low > 0 || b.high < 0)) return Interval::everything();
  return a * outward(1 / b.high, 1 / b.low);
}

inline Interval square(const Interval& a) {
  const double l = a.low * a.low, h = a.high * a.high;
  const Interval out = outward(a.contains(0) ? 0 : std::min(l, h), std::max(l, h));
  return {std::max(out.low, 0.0), out.high};
}

/// Of the part that is not negative: the caller knows that no member is, and that only the bounds' width says so.
inline Interval sqrt(const Interval& a) {
  if (!(a.high >= 0)) return Interval::everything();
  const Interval out = outward(std::sqrt(std::max(a.low, 0.0)), std::sqrt(a.high));
  return {std::max(out.low, 0.0), out.high};
}

/// libm's exp is within an ulp.
inline Interval exp(const Interval& a) {
  const Interval out = outward(std::exp(a.low), std::exp(a.high));
  return {std::max(out.low, 0.0), out.high};
}

/// cos(pi x) and sin(pi x) with x in half turns.
Interval cos_pi(const Interval& half_turns);
inline Interval sin_pi(const Interval& half_turns) { return cos_pi(half_turns - Interval(0.5)); }
/// sin(pi x)/(pi x).
Interval sinc_pi(const Interval& half_turns);

inline Interval intersection(const Interval& a, const Interval& b) {
  const double l = std::max(a.low, b.low), h = std::min(a.high, b.high);
  return l <= h ? Interval(l, h) : a;  // disjoint only if one of them is wrong; never happens to valid bounds
}

}  // namespace scatmap
