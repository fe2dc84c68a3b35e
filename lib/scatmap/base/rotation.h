#pragma once
#include <cmath>

#include "scatmap/base/direction.h"

/// Active right-handed rotations: rotation_y(a)·z = (sin a, 0, cos a); rotation_x(a)·z = (0, −sin a, cos a). Radians.
namespace scatmap {

template <class T>
Matrix3<T> rotation_x(const T& angle) {
  using std::cos;
  using std::sin;
  const T c = cos(angle), s = sin(angle);
  Matrix3<T> m;
  m << T(1), T(0), T(0), T(0), c, -s, T(0), s, c;
  return m;
}

template <class T>
Matrix3<T> rotation_y(const T& angle) {
  using std::cos;
  using std::sin;
  const T c = cos(angle), s = sin(angle);
  Matrix3<T> m;
  m << c, T(0), s, T(0), T(1), T(0), -s, T(0), c;
  return m;
}

template <class T>
Matrix3<T> rotation_z(const T& angle) {
  using std::cos;
  using std::sin;
  const T c = cos(angle), s = sin(angle);
  Matrix3<T> m;
  m << c, -s, T(0), s, c, T(0), T(0), T(0), T(1);
  return m;
}

}  // namespace scatmap
