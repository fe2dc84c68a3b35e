#include "scatmap/brdf/fused_kernels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "scatmap/base/simd.h"
#include "scatmap/counts/expected_signal.h"

namespace scatmap {
namespace {

constexpr int kFull = kWindowRows * kWindowRows - 1;  // neighbours of a pixel in the middle of good ones
constexpr std::int32_t kInfinite = 0x7f800000, kMagnitude = 0x7fffffff;  // bit patterns of floats

// Magnitudes order as their bit patterns do, NaN past infinity.
SCATMAP_INLINE std::int32_t magnitude(float x) { return std::bit_cast<std::int32_t>(x) & kMagnitude; }

// Whether all values and the sums of their variances are finite.
SCATMAP_INLINE bool all_finite(const CleanRow& row, int pixels) {
  const float *value = row.value, *floor = row.floor, *shot = row.shot;
  std::int32_t largest = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) {
    const std::int32_t of_value = magnitude(value[i]), of_variance = magnitude(floor[i] + shot[i]);
    const std::int32_t bits = of_value > of_variance ? of_value : of_variance;
    largest = bits > largest ? bits : largest;
  }
  return largest < kInfinite;
}

SCATMAP_INLINE void clear_masked(const Mask* mask, int n, float* value, std::uint8_t* good) {
  Mask any = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    any = static_cast<Mask>(any | mask[i]);
    good[i] = static_cast<std::uint8_t>(mask[i] == 0 ? 1 : 0);
  }
  for (int i = 0; any != 0 && i < n; ++i) value[i] = mask[i] == 0 ? value[i] : 0;
}

// Rows in which something overflowed. @return whether that is so where the mask does not say so
SCATMAP_INLINE bool clean_odd_row(const Mask* mask, int pixels, const CleanRow& row, std::uint8_t* good) {
  bool odd = false;
  for (int i = 0; i < pixels; ++i) {
    const bool finite = magnitude(row.value[i]) < kInfinite && magnitude(row.floor[i] + row.shot[i]) < kInfinite;
    odd = odd || (mask[i] == 0 && !finite);
    good[i] = mask[i] == 0 && finite ? 1 : 0;
    if (good[i] == 0) row.value[i] = 0;
  }
  return odd;
}

}  // namespace

SCATMAP_CLONES bool clean_row(const Mask* mask, int pixels, const CleanRow& row, std::uint8_t* good) {
  if (!all_finite(row, pixels)) return clean_odd_row(mask, pixels, row, good);
  constexpr int kPart = 64;  // most parts have no masked pixel
  int first = 0;
  for (; first + kPart <= pixels; first += kPart) clear_masked(mask + first, kPart, row.value + first, good + first);
  clear_masked(mask + first, pixels - first, row.value + first, good + first);
  return false;
}

namespace {

// What expected_signal.h wants to know of a number of neighbours.
struct OfCount {
  double per_count, per_degree;
  float chance;
};

const std::array<OfCount, kFull + 1>& of_counts() {
  static const auto kTable = [] {
    std::array<OfCount, kFull + 1> out{};
    for (std::size_t k = kLeastNeighbours; k < out.size(); ++k) {
      const auto n = static_cast<double>(k);
      out[k] = {1 / n, 1 / (n - 1), static_cast<float>(1 + kStructureSigmas * std::sqrt(2 / (n - 1)))};
    }
    return out;
  }();
  return kTable;
}

constexpr int kPadded = kStrip + 2 * kRowMargin;
constexpr int kSide = kRowMargin - kWindowReach;  // from the margin's edge to the window's

// Sums over the window's rows, column by column, with the row in hand and without: in double, as the scatter behind
// them may be a small difference.
struct ColumnSums {
  alignas(64) double value[kPadded], square[kPadded], other_value[kPadded], other_square[kPadded];
  alignas(64) std::uint8_t count[kPadded];
};

SCATMAP_INLINE void sum_columns(const WindowRows& rows, int n, ColumnSums& s) {
  const float *v0 = rows.value[0] - kRowMargin, *v1 = rows.value[1] - kRowMargin, *v2 = rows.value[2] - kRowMargin,
              *v3 = rows.value[3] - kRowMargin, *v4 = rows.value[4] - kRowMargin;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const double a = v0[i], b = v1[i], c = v2[i], d = v3[i], e = v4[i];
    const double others = (a + b) + (d + e), squares = (a * a + b * b) + (d * d + e * e);
    s.other_value[i] = others;
    s.other_square[i] = squares;
    s.value[i] = others + c;
    s.square[i] = squares + c * c;
  }
  const std::uint8_t *g0 = rows.good[0] - kRowMargin, *g1 = rows.good[1] - kRowMargin, *g2 = rows.good[2] - kRowMargin,
                     *g3 = rows.good[3] - kRowMargin, *g4 = rows.good[4] - kRowMargin;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) s.count[i] = static_cast<std::uint8_t>(g0[i] + g1[i] + g2[i] + g3[i] + g4[i]);
}

// Sums of all good pixels around one.
struct Neighbours {
  double value, square;
};

SCATMAP_INLINE Neighbours neighbours(const ColumnSums& s, int i) {
  const double *value = s.value + kSide, *square = s.square + kSide;
  return {((value[i] + value[i + 1]) + (value[i + 3] + value[i + 4])) + s.other_value[i + kRowMargin],
          ((square[i] + square[i + 1]) + (square[i + 3] + square[i + 4])) + s.other_square[i + kRowMargin]};
}

struct Estimate {
  double expected;
  float variance;
};

constexpr float kTiny = std::numeric_limits<float>::min();  // noise of 0 explains nothing, and divides nothing by 0

// expected_signal.h: differences of sums in double, what is left of them in float.
SCATMAP_INLINE Estimate local_estimate(const Neighbours& s, const OfCount& k, float own, float floor, float shot) {
  const double mean = s.value * k.per_count;
  const auto scatter = static_cast<float>((s.square - s.value * mean) * k.per_degree),
             mean_f = static_cast<float>(mean);
  const float noise = floor + (mean_f > 0 ? mean_f : 0) * shot + kTiny, excess = scatter - noise * k.chance;
  const float structure = excess > 0 ? excess : 0;
  const float of_own = structure / (structure + noise) * (own - mean_f);
  return {mean + static_cast<double>(of_own), variance_at(mean_f + of_own, floor, shot)};
}

// What goes from loop to loop, each with a chain of dependent steps that is short enough to be worked on for several
// vectors at once.
struct Estimates {
  alignas(64) double expected[kStrip];
  alignas(64) float variance[kStrip];
};

SCATMAP_INLINE void estimate(const ColumnSums& sums, const float* own, const float* floor, const float* shot, int n,
                             Estimates& out) {
  const OfCount full = of_counts()[kFull];
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const Estimate e = local_estimate(neighbours(sums, i), full, own[i], floor[i], shot[i]);
    out.expected[i] = e.expected;
    out.variance[i] = e.variance;
  }
}

// The few pixels whose window is not full, NaN where they are not good themselves: `odd` is not 0 there.
void estimate_odd(const ColumnSums& sums, const std::uint8_t* odd, const std::uint8_t* good, const float* own,
                  const float* floor, const float* shot, int n, Estimates& out) {
  constexpr int kWord = 8;
  const auto& table = of_counts();
  for (int first = 0; first < n; first += kWord) {
    std::uint64_t any = 0;
    std::memcpy(&any, odd + first, sizeof any);
    for (int i = first; any != 0 && i < std::min(n, first + kWord); ++i) {
      if (odd[i] == 0) continue;
      const auto count = static_cast<std::size_t>(kFull + 1 - odd[i] - good[i]);
      Estimate e{own[i], variance_at(own[i], floor[i], shot[i])};
      if (count >= kLeastNeighbours) e = local_estimate(neighbours(sums, i), table[count], own[i], floor[i], shot[i]);
      out.expected[i] = good[i] != 0 ? e.expected : std::numeric_limits<double>::quiet_NaN();
      out.variance[i] = good[i] != 0 ? e.variance : std::numeric_limits<float>::quiet_NaN();
    }
  }
}

// Good pixels that each window lacks. @return whether any does
SCATMAP_INLINE bool missing(const ColumnSums& sums, int n, std::uint8_t* odd) {
  const std::uint8_t* seen = sums.count + kSide;
  std::uint8_t any = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    odd[i] = static_cast<std::uint8_t>(kFull + 1 - (seen[i] + seen[i + 1] + seen[i + 2] + seen[i + 3] + seen[i + 4]));
    any = static_cast<std::uint8_t>(any | odd[i]);
  }
  return any != 0;
}

// @return largest bit pattern of a BRDF
SCATMAP_INLINE std::int32_t divide(const Estimates& e, const float* own, const double* per_dn, int n,
                                   const BrdfStrip& out) {
  float *brdf = out.brdf_per_sr, *u_random = out.u_random_per_sr;
  double* expected = out.expected_per_sr;
  std::int32_t largest = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const auto scale = static_cast<float>(per_dn[i]);
    const float quotient = own[i] * scale, variance = e.variance[i];
    expected[i] = e.expected[i] * per_dn[i];
    u_random[i] = std::sqrt(variance) * scale;
    brdf[i] = variance == variance ? quotient : variance;  // NaN where the pixel is not good
    const std::int32_t bits = magnitude(quotient);
    largest = bits > largest ? bits : largest;
  }
  return largest;
}

}  // namespace

SCATMAP_CLONES bool map_strip(const WindowRows& rows, const float* floor, const float* shot, const double* per_dn,
                              int pixels, const BrdfStrip& out) {
  ColumnSums sums;
  Estimates estimates;
  alignas(64) std::uint8_t odd[kStrip] = {};  // read by whole words
  const float* own = rows.value[kWindowReach];
  sum_columns(rows, pixels + 2 * kRowMargin, sums);
  estimate(sums, own, floor, shot, pixels, estimates);
  if (missing(sums, pixels, odd)) estimate_odd(sums, odd, rows.good[kWindowReach], own, floor, shot, pixels, estimates);
  return divide(estimates, own, per_dn, pixels, out) >= kInfinite;
}

GeometryRow geometry_row(const SampleView& view, int row) {
  const Vector3<double> at = view.pixel(0, row), &step = view.column_step;
  return {at.x(),
          at.y(),
          at.z(),
          step.x(),
          step.y(),
          step.z(),
          view.detector_normal.dot(at),
          view.detector_normal.dot(step),
          view.pixel_area_m2};
}

namespace {

// |D|² is a parabola along the row, n·D a straight line, and D along the normal is the same for all pixels of a plane.
struct AlongRow {
  double square, linear, quadratic, z, z_step, scale;
};

AlongRow along_row(const GeometryRow& g, double scale, double column) {
  const double x = g.x + column * g.x_step, y = g.y + column * g.y_step, z = g.z + column * g.z_step;
  return {x * x + y * y + z * z,
          2 * (x * g.x_step + y * g.y_step + z * g.z_step),
          g.x_step * g.x_step + g.y_step * g.y_step + g.z_step * g.z_step,
          z,
          g.z_step,
          scale / (g.area_m2 * g.facing)};
}

constexpr double kPolynomialMaxError = 1e-8;  // relative; smooth, so that gradients hardly see it
constexpr std::size_t kTerms = 5;

// N(u)/(1 + t u) with N = (1 + p u + q u²)², of degree 4, is the sum of c_k u^k with c_k = N_k − t c_(k−1), and what is
// left after u⁴ is −t c₄ u⁵/(1 + t u).
struct Series {
  std::array<double, kTerms> c;
  double remainder;  // relative, for |u| up to `half`
};

Series series(const AlongRow& a, double half) {
  const double p = a.linear / a.square, q = a.quadratic / a.square, t = a.z_step / a.z;
  Series out{{1, 2 * p, p * p + 2 * q, 2 * p * q, q * q}, 0};
  for (std::size_t k = 1; k < kTerms; ++k) out.c[k] -= t * out.c[k - 1];
  const double th = std::abs(t) * half, h2 = half * half;
  // Relative to N, which is not below (1 − 0.3)² there.
  constexpr double kMostSlope = 0.3, kPerLeast = 1 / ((1 - kMostSlope) * (1 - kMostSlope));
  const bool slow = std::abs(p) * half < kMostSlope && th < kMostSlope;
  out.remainder = slow ? kPerLeast * th * std::abs(out.c[4]) * h2 * h2 : 1;
  const double whole = a.square * a.square * a.scale / a.z;
  for (double& c : out.c) c *= whole;
  return out;
}

}  // namespace

SCATMAP_CLONES void inverse_projected(const GeometryRow& g, double scale, int first, int pixels, double* out) {
  constexpr int kPart = 288;
  for (int begin = 0; begin < pixels; begin += kPart) {
    const int n = std::min(kPart, pixels - begin);
    const double half = 0.5 * (n - 1);
    const AlongRow at = along_row(g, scale, first + begin + half);
    const Series s = series(at, half);
    double* to = out + begin;
    if (s.remainder <= kPolynomialMaxError) {
      const double c0 = s.c[0], c1 = s.c[1], c2 = s.c[2], c3 = s.c[3], c4 = s.c[4];
      SCATMAP_INDEPENDENT
      for (int i = 0; i < n; ++i) {
        const double u = i - half;
        to[i] = c0 + u * (c1 + u * (c2 + u * (c3 + u * c4)));
      }
      continue;
    }
    const double whole = at.scale;
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) {
      const double u = i - half, r2 = at.square + u * (at.linear + u * at.quadratic);
      to[i] = r2 * r2 * whole / (at.z + u * at.z_step);
    }
  }
}

}  // namespace scatmap
