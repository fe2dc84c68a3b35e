#include "scatmap/angles/taylor_bound.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace scatmap {
namespace {

double power(double base, int exponent) {
  double product = 1;
  for (int k = 0; k < exponent; ++k) product *= base;
  return product;
}

}  // namespace

double taylor_remainder_rad(const LineSize& line, double half, int degree) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double across = half * line.q / line.rho_min, along = half * line.s / line.r_min;
  const int next = degree + 1;
  // Circle that the pole stays well outside of: the estimate is then within a few times the best circle's.
  constexpr double kReach = 0.6, kSmallestCircle = 1.5;
  const double circle = kReach / std::max(across, along);
  if (!(line.rho_min > 0 && line.r_min > 0 && circle >= kSmallestCircle)) return kNever;

  const double sin_theta = std::min(1.0, (line.rho_max + half * line.q) / (line.r_min - half * line.s));
  const double phi = power(across, next) / (next * (1 - across));

  const double a = circle * across, b = circle * along;  // relative change of rho and r on the circle
  const double slope = (line.q * (1 + a) / (1 - a) * line.r_max * (1 + b) + line.rho_max * (1 + a) * line.s) /
                       (line.r_min * line.r_min * (1 - b) * (1 - b));
  const double theta = half * slope / (next * power(circle, degree) * (1 - 1 / circle));
  return std::hypot(theta, sin_theta * phi);
}

}  // namespace scatmap
