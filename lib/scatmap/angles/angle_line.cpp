#include "scatmap/angles/angle_line.h"

namespace scatmap {

bool is_near_line(const Vector3<double>& p, const Vector3<double>& u, double h) {
  constexpr double kRange = 0.999 * kSmallArctangentRange, kSeam = 1e-6;  // more than float32 rounds
  const double rho2 = p.x() * p.x() + p.y() * p.y();
  // |tan| of the angle between two directions is |a × b|/a·b; theta changes by no more than the direction.
  const double turn = h * std::abs(p.x() * u.y() - p.y() * u.x());
  const double flat = rho2 - h * std::abs(p.x() * u.x() + p.y() * u.y());
  const double way = h * p.cross(u).norm(), along = p.squaredNorm() - h * std::abs(p.dot(u));
  // Half way to the pole and farther, rho² = rho_ref² + rise loses digits; and in float32 rho² must not vanish.
  if (!(flat >= 0.5 * rho2 && rho2 > 1e-12 * p.squaredNorm())) return false;
  if (!(turn <= kRange * flat && way <= kRange * along)) return false;
  // The seam lies at y = 0, x < 0.
  return p.x() > 0 || std::abs(p.y()) * flat > turn * std::sqrt(rho2) + kSeam * rho2 * std::sqrt(rho2);
}

}  // namespace scatmap
