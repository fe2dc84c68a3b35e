#include "scatmap/angles/direction_pixels.h"

#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>

#include "scatmap/base/simd.h"

namespace scatmap {
namespace {

// Pixel offsets from the middle are (a·d)/(f·d) and (b·d)/(f·d): rows of the inverse of (column step, row step,
// middle).
struct Inverse {
  double a[3], b[3], f[3];
  double column, row;  ///< of the middle
  double parallel2;    ///< (f·d)² is rounding error below this times |d|²
};

struct WideVector {
  long double v[3];
};

WideVector cross(const WideVector& a, const WideVector& b) {
  return {{a.v[1] * b.v[2] - a.v[2] * b.v[1], a.v[2] * b.v[0] - a.v[0] * b.v[2], a.v[0] * b.v[1] - a.v[1] * b.v[0]}};
}

WideVector wide(const Vector3<double>& v) { return {{v.x(), v.y(), v.z()}}; }

Inverse inverse_of(const SampleView& view, int rows, int columns) {
  Inverse out{};
  out.column = 0.5 * (columns - 1);
  out.row = 0.5 * (rows - 1);
  const WideVector u = wide(view.column_step), v = wide(view.row_step);
  WideVector middle = wide(view.origin);
  for (int k = 0; k < 3; ++k) middle.v[k] += out.column * u.v[k] + out.row * v.v[k];
  const WideVector a = cross(v, middle), b = cross(middle, u), f = cross(u, v);
  long double volume = 0, f2 = 0;
  for (int k = 0; k < 3; ++k) volume += f.v[k] * middle.v[k];
  // Lengths in pixels and sign chosen so that f·d is 1 at the middle's own ray: positive ahead of the spot.
  for (int k = 0; k < 3; ++k) {
    out.a[k] = static_cast<double>(a.v[k] / volume);
    out.b[k] = static_cast<double>(b.v[k] / volume);
    out.f[k] = static_cast<double>(f.v[k] / volume);
    f2 += (f.v[k] / volume) * (f.v[k] / volume);
  }
  constexpr double kParallel = 1e-13;
  out.parallel2 = static_cast<double>(kParallel * kParallel * f2);
  return out;
}

SCATMAP_CLONES void run_inverse(const Inverse& m, std::size_t n, const double* x, const double* y, const double* z,
                                double* column, double* row) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < n; ++i) {
    const double f = m.f[0] * x[i] + m.f[1] * y[i] + m.f[2] * z[i];
    const double a = m.a[0] * x[i] + m.a[1] * y[i] + m.a[2] * z[i];
    const double b = m.b[0] * x[i] + m.b[1] * y[i] + m.b[2] * z[i];
    const double length2 = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
    const bool meets = f > 0 && f * f > m.parallel2 * length2;
    const double scale = meets ? 1 / f : kNaN;
    column[i] = m.column + a * scale;
    row[i] = m.row + b * scale;
  }
}

}  // namespace

void pixels_of_directions(const SampleView& view, int rows, int columns, const DirectionSpans& d,
                          const PixelSpans& out) {
  assert(d.y.size() == d.x.size() && d.z.size() == d.x.size());
  assert(out.column.size() == d.x.size() && out.row.size() == d.x.size());
  run_inverse(inverse_of(view, rows, columns), d.x.size(), d.x.data(), d.y.data(), d.z.data(), out.column.data(),
              out.row.data());
}

}  // namespace scatmap
