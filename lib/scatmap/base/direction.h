#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

/// Every numerical trap of directions and angles stands here, once. Directions are vectors; (theta, phi) is only for
/// people and files, because phi is undefined at theta = 0. Nothing here takes acos of a dot product: near the peak
/// that loses half the digits (float32 acos(cos 2e-4) is 0). Templated on the scalar: double for the product, long
/// double for references, automatic-differentiation types for calibration. No function throws; NaN in gives NaN out.
namespace scatmap {

template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

/// Polar angle of v from +z, in [0, pi] rad; v of any length > 0.
template <class T>
T polar_angle(const Vector3<T>& v) {
  using std::atan2;
  using std::sqrt;
  return atan2(sqrt(v.x() * v.x() + v.y() * v.y()), v.z());
}

/// Azimuth of v measured from −x towards −y, in [0, 2 pi) rad: the paper's phi, so that phi_i = 0, specular is
/// phi_s = pi, and the seam lies at back-scatter. 0 where v is along z.
template <class T>
T azimuth_from_minus_x(const Vector3<T>& v) {
  using std::atan2;
  constexpr T two_pi = 2 * std::numbers::pi_v<T>;
  const T from_plus_x = atan2(v.y(), v.x());
  const T phi = from_plus_x + std::numbers::pi_v<T>;
  return phi >= two_pi ? T(0) : phi;
}

/// Unit direction with polar angle theta and azimuth phi from −x, rad. Inverse of the two functions above.
template <class T>
Vector3<T> direction_from_angles(T theta, T phi) {
  using std::cos;
  using std::sin;
  return {-sin(theta) * cos(phi), -sin(theta) * sin(phi), cos(theta)};
}

/// Angle between a and b, in [0, pi] rad, accurate at 0 and pi; lengths any > 0.
template <class T>
T angle_between(const Vector3<T>& a, const Vector3<T>& b) {
  using std::atan2;
  return atan2(a.cross(b).norm(), a.dot(b));
}

/// Unit half vector of two unit directions (paper, Eq. 4); NaN where wi = −ws.
template <class T>
Vector3<T> half_vector(const Vector3<T>& wi, const Vector3<T>& ws) {
  const Vector3<T> sum = wi + ws;
  return sum / sum.norm();
}

/// tan² of the polar angle of v, straight from the components: no cancellation at v = z.
template <class T>
T tan2_polar(const Vector3<T>& v) {
  return (v.x() * v.x() + v.y() * v.y()) / (v.z() * v.z());
}

}  // namespace scatmap
