#pragma once
#include <cmath>
#include <numbers>

namespace scatmap::synth {

inline constexpr long double kPi = std::numbers::pi_v<long double>;

/// Three long double components; the truth's own vector, so that it shares no arithmetic with the code it tests.
struct Vec3 {
  long double x = 0, y = 0, z = 0;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(long double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline long double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline long double length(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline Vec3 unit(const Vec3& a) { return (1 / length(a)) * a; }

/// Active right-handed turns by an angle in degrees: turn_y({0,0,1}, a) = (sin a, 0, cos a),
/// turn_x({0,0,1}, a) = (0, −sin a, cos a), turn_z({1,0,0}, a) = (cos a, sin a, 0).
inline Vec3 turn_x(const Vec3& v, long double angle_deg) {
  const long double a = angle_deg * kPi / 180, c = std::cos(a), s = std::sin(a);
  return {v.x, c * v.y - s * v.z, s * v.y + c * v.z};
}
inline Vec3 turn_y(const Vec3& v, long double angle_deg) {
  const long double a = angle_deg * kPi / 180, c = std::cos(a), s = std::sin(a);
  return {c * v.x + s * v.z, v.y, c * v.z - s * v.x};
}
inline Vec3 turn_z(const Vec3& v, long double angle_deg) {
  const long double a = angle_deg * kPi / 180, c = std::cos(a), s = std::sin(a);
  return {c * v.x - s * v.y, s * v.x + c * v.y, v.z};
}

}  // namespace scatmap::synth
