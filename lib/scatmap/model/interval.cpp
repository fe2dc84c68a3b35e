#include "scatmap/model/interval.h"

#include <numbers>

namespace scatmap {
namespace {

// Error of cos(pi x) as computed below: the reduction is exact, pi·x and libm round.
constexpr double kCosineError = 1e-15;

double cos_pi(double half_turns) { return std::cos(std::numbers::pi * std::remainder(half_turns, 2.0)); }

// Whether an even (or odd) integer lies in [low, high].
bool holds_even(const Interval& x) { return 2 * std::floor(x.high / 2) >= x.low; }
bool holds_odd(const Interval& x) { return 2 * std::floor((x.high - 1) / 2) + 1 >= x.low; }

double sinc_pi(double half_turns) {
  if (half_turns == 0) return 1;
  return std::sin(std::numbers::pi * std::remainder(half_turns, 2.0)) / (std::numbers::pi * half_turns);
}

}  // namespace

Interval cos_pi(const Interval& half_turns) {
  // Beyond 2^50 half turns floor() no longer tells integers apart.
  if (!(half_turns.magnitude() < 1e15) || half_turns.width() >= 2) return {-1, 1};
  const double a = cos_pi(half_turns.low), b = cos_pi(half_turns.high);
  return {holds_odd(half_turns) ? -1 : std::max(std::min(a, b) - kCosineError, -1.0),
          holds_even(half_turns) ? 1 : std::min(std::max(a, b) + kCosineError, 1.0)};
}

Interval sinc_pi(const Interval& half_turns) {
  const double nearest = half_turns.contains(0) ? 0 : std::min(std::abs(half_turns.low), std::abs(half_turns.high));
  const double farthest = half_turns.magnitude();
  // Falls from 1 to 0 over the first half turn; beyond it |sinc| < 1/(pi x).
  if (farthest <= 1) {
    return {std::max(sinc_pi(farthest) - kCosineError, 0.0), std::min(sinc_pi(nearest) + kCosineError, 1.0)};
  }
  if (nearest < 1) return {-0.22, 1};  // its deepest minimum is −0.2173
  const double most = outward(0, 1 / (std::numbers::pi * nearest)).high;
  return {-most, most};
}

}  // namespace scatmap
