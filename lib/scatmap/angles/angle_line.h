#pragma once
#include <cmath>
#include <numbers>
#include <type_traits>

#include "scatmap/angles/angle_kernel.h"
#include "scatmap/angles/pixel_plane.h"

/// References of the angle methods: a few per row, in extended precision.
namespace scatmap {

using Wide = long double;

/// What references of results in T are computed in: their own rounding must not show.
template <class T>
using ReferenceReal = std::conditional_t<std::is_same_v<T, float>, double, Wide>;

template <class R>
struct RayOf {
  R x, y, z;
  R length() const { return std::sqrt(x * x + y * y + z * z); }
};
using WideRay = RayOf<Wide>;

/// From the spot to a pixel position, m.
template <class R = Wide>
RayOf<R> reference_ray(const SampleView& v, double column, double row) {
  const auto along = [&](int k) { return v.origin[k] + R(row) * v.row_step[k] + R(column) * v.column_step[k]; };
  return {along(0), along(1), along(2)};
}

/// A number as a sum of two.
template <class T>
struct TwoParts {
  template <class R>
  explicit TwoParts(R value) : high(static_cast<T>(value)), rest(static_cast<T>(value - high)) {}
  T high, rest;
};

/// Points on a line in the detector plane: `reference` + d·step for d = first_d, first_d + 1, …
template <class T, class R>
kernel::FarSegment<T> far_segment(const RayOf<R>& reference, const Vector3<double>& step, double first_d) {
  const R r = reference.length();
  const TwoParts<T> x(reference.x / r), y(reference.y / r), z(reference.z / r);
  const auto part = [&](int k) { return static_cast<T>(step[k] / r); };
  return {static_cast<T>(first_d), x.high, y.high, z.high, x.rest, y.rest, z.rest, part(0), part(1), part(2)};
}

/// Whether every point within `half` steps of the reference lies so near it that small_arctangent serves for both
/// angles, with phi off the seam.
bool is_near_line(const Vector3<double>& reference, const Vector3<double>& step, double half);

/// The same line for points near the reference. @pre is_near_line
template <class T, class R>
kernel::NearSegment<T> near_segment(const RayOf<R>& p, const Vector3<double>& u, double first_d) {
  const R rho2 = p.x * p.x + p.y * p.y, r2 = rho2 + p.z * p.z, rho = std::sqrt(rho2), r = std::sqrt(r2);
  const R across = p.x * u.y() - p.y * u.x(), along = p.x * u.x() + p.y * u.y();
  const TwoParts<T> phi(std::atan2(p.y, p.x) + std::numbers::pi_v<R>), theta(std::atan2(rho, p.z));
  kernel::NearSegment<T> out;
  out.first_d = static_cast<T>(first_d);
  out.phi = phi.high;
  out.phi_rest = phi.rest;
  out.theta = theta.high;
  out.theta_rest = theta.rest;
  out.turn = static_cast<T>(across / rho2);
  out.stretch = static_cast<T>(along / rho2);
  out.rho = static_cast<T>(rho / r);
  out.z = static_cast<T>(p.z / r);
  out.rho2_linear = static_cast<T>(2 * along / r2);
  out.rho2_square = static_cast<T>((R(u.x()) * u.x() + R(u.y()) * u.y()) / r2);
  out.z_step = static_cast<T>(u.z() / r);
  return out;
}

}  // namespace scatmap
