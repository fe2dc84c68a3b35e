#pragma once
#include <cmath>

#include "scatmap/angles/angle_kernel.h"
#include "scatmap/angles/pixel_plane.h"

/// References of the angle methods: a few per row, in extended precision.
namespace scatmap {

using Wide = long double;

struct WideRay {
  Wide x, y, z;
  Wide length() const { return std::sqrt(x * x + y * y + z * z); }
};

/// From the spot to a pixel position, m.
inline WideRay wide_ray(const SampleView& v, double column, double row) {
  const auto along = [&](int k) { return v.origin[k] + Wide(row) * v.row_step[k] + Wide(column) * v.column_step[k]; };
  return {along(0), along(1), along(2)};
}

/// A number as a sum of two.
template <class T>
struct TwoParts {
  explicit TwoParts(Wide value) : high(static_cast<T>(value)), rest(static_cast<T>(value - high)) {}
  T high, rest;
};

/// Points on a line in the detector plane: `reference` + d·step for d = first_d, first_d + 1, …
template <class T>
kernel::FarSegment<T> far_segment(const WideRay& reference, const Vector3<double>& step, double first_d) {
  const Wide r = reference.length();
  const TwoParts<T> x(reference.x / r), y(reference.y / r), z(reference.z / r);
  const auto part = [&](int k) { return static_cast<T>(step[k] / r); };
  return {static_cast<T>(first_d), x.high, y.high, z.high, x.rest, y.rest, z.rest, part(0), part(1), part(2)};
}

}  // namespace scatmap
