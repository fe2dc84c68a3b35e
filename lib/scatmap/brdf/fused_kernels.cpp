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

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kLargest = std::numeric_limits<double>::max();
constexpr int kPadded = kStrip + 2 * kRowMargin;
constexpr int kSide = kRowMargin - kWindowReach;      // from the margin's edge to the window's
constexpr int kFull = kWindowRows * kWindowRows - 1;  // neighbours of a pixel in the middle of good ones

// Sums over the window's rows, column by column.
struct ColumnSums {
  alignas(64) double value[kPadded], square[kPadded];
  alignas(64) std::uint8_t count[kPadded];
};

SCATMAP_INLINE void sum_columns(const WindowRows& rows, int first, int n, ColumnSums& s) {
  const double *v0 = rows.value[0] + first, *v1 = rows.value[1] + first, *v2 = rows.value[2] + first,
               *v3 = rows.value[3] + first, *v4 = rows.value[4] + first;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    s.value[i] = v0[i] + v1[i] + v2[i] + v3[i] + v4[i];
    s.square[i] = v0[i] * v0[i] + v1[i] * v1[i] + v2[i] * v2[i] + v3[i] * v3[i] + v4[i] * v4[i];
  }
  const std::uint8_t *g0 = rows.good[0] + first, *g1 = rows.good[1] + first, *g2 = rows.good[2] + first,
                     *g3 = rows.good[3] + first, *g4 = rows.good[4] + first;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) s.count[i] = static_cast<std::uint8_t>(g0[i] + g1[i] + g2[i] + g3[i] + g4[i]);
}

// Of all good pixels around one, its neighbours' sums.
struct Neighbours {
  double value, square;
};

SCATMAP_INLINE Neighbours neighbours(const ColumnSums& s, int i, double own) {
  const double *value = s.value + kSide, *square = s.square + kSide;
  return {value[i] + value[i + 1] + value[i + 2] + value[i + 3] + value[i + 4] - own,
          square[i] + square[i + 1] + square[i + 2] + square[i + 3] + square[i + 4] - own * own};
}

// expected_signal.h, with the numbers that depend on the count given.
SCATMAP_INLINE double local_estimate(const Neighbours& s, double per_count, double per_degree, double chance,
                                     double own, double floor, double shot) {
  const double mean = s.value * per_count;
  const double scatter = (s.square - s.value * mean) * per_degree;
  const double noise = floor + (mean > 0 ? mean : 0) * shot;
  const double excess = scatter - noise * chance;
  const double structure = excess > 0 ? excess : 0;
  // A share of the signal's structure: float keeps the variance within its bound, and divides twice as many at a time.
  const float share = static_cast<float>(structure) / static_cast<float>(structure + noise);
  return mean + static_cast<double>(share) * (own - mean);
}

// What local_estimate() wants to know of a number of neighbours.
struct OfCount {
  double per_count, per_degree, chance;
};

const std::array<OfCount, kFull + 1>& of_counts() {
  static const auto kTable = [] {
    std::array<OfCount, kFull + 1> out{};
    for (std::size_t k = kLeastNeighbours; k < out.size(); ++k) {
      const auto n = static_cast<double>(k);
      out[k] = {1 / n, 1 / (n - 1), 1 + kStructureSigmas * std::sqrt(2 / (n - 1))};
    }
    return out;
  }();
  return kTable;
}

}  // namespace

namespace {

constexpr std::int64_t kInfinite = 0x7ff0000000000000, kMagnitude = 0x7fffffffffffffff;

// Whether all values and the sums of their variances are finite: by the largest bit patterns, which order as magnitudes
// do, NaN past infinity.
SCATMAP_INLINE bool all_finite(const CleanRow& row, int pixels) {
  const double* value = row.value;
  const float *floor = row.floor, *shot = row.shot;
  std::int64_t largest = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) {
    const std::int64_t bits = std::bit_cast<std::int64_t>(value[i]) & kMagnitude;
    largest = bits > largest ? bits : largest;
  }
  constexpr std::int32_t kFloatInfinite = 0x7f800000, kFloatMagnitude = 0x7fffffff;
  std::int32_t largest_sum = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) {
    const std::int32_t bits = std::bit_cast<std::int32_t>(floor[i] + shot[i]) & kFloatMagnitude;
    largest_sum = bits > largest_sum ? bits : largest_sum;
  }
  return largest < kInfinite && largest_sum < kFloatInfinite;
}

SCATMAP_INLINE void clear_masked(const Mask* mask, int n, double* value, std::uint8_t* good) {
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
    const bool finite =
        std::abs(row.value[i]) <= kLargest && row.floor[i] + row.shot[i] <= std::numeric_limits<float>::max();
    odd = odd || (mask[i] == 0 && !finite);
    good[i] = mask[i] == 0 && finite ? 1 : 0;
    if (good[i] == 0) row.value[i] = 0;
  }
  return odd;
}

}  // namespace

SCATMAP_CLONES bool clean_row(const Mask* mask, int pixels, const CleanRow& row, std::uint8_t* good) {
  if (!all_finite(row, pixels)) return clean_odd_row(mask, pixels, row, good);
  constexpr int kBlock = 64;  // most blocks have no masked pixel
  int first = 0;
  for (; first + kBlock <= pixels; first += kBlock) clear_masked(mask + first, kBlock, row.value + first, good + first);
  clear_masked(mask + first, pixels - first, row.value + first, good + first);
  return false;
}

namespace {

// The few pixels of a strip whose window is not full: `odd` is not 0 there.
void estimate_odd(const ColumnSums& sums, const std::uint8_t* odd, const std::uint8_t* count, const std::uint8_t* good,
                  const double* own, const float* floor, const float* shot, int n, double* expected) {
  constexpr int kWord = 8;
  const auto& table = of_counts();
  for (int first = 0; first < n; first += kWord) {
    std::uint64_t any = 0;
    std::memcpy(&any, odd + first, sizeof any);
    for (int i = first; any != 0 && i < std::min(n, first + kWord); ++i) {
      if (odd[i] == 0) continue;
      const OfCount& k = table[count[i]];
      const double estimate = count[i] < kLeastNeighbours
                                  ? own[i]
                                  : local_estimate(neighbours(sums, i, own[i]), k.per_count, k.per_degree, k.chance,
                                                   own[i], static_cast<double>(floor[i]), static_cast<double>(shot[i]));
      expected[i] = good[i] == 0 ? kNaN : estimate;
    }
  }
}

}  // namespace

SCATMAP_CLONES void expected_row(const WindowRows& rows, const float* floor, const float* shot, int pixels,
                                 double* expected) {
  ColumnSums sums;
  alignas(64) std::uint8_t count[kStrip], odd[kStrip] = {};
  const OfCount full = of_counts()[kFull];
  for (int first = 0; first < pixels; first += kStrip) {
    const int n = std::min(kStrip, pixels - first);
    sum_columns(rows, first - kRowMargin, n + 2 * kRowMargin, sums);
    const double* own = rows.value[kWindowReach] + first;
    const std::uint8_t* good = rows.good[kWindowReach] + first;
    const std::uint8_t* seen = sums.count + kSide;
    std::uint8_t any = 0;
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) {
      const auto all = static_cast<std::uint8_t>(seen[i] + seen[i + 1] + seen[i + 2] + seen[i + 3] + seen[i + 4]);
      count[i] = static_cast<std::uint8_t>(all - good[i]);
      odd[i] = static_cast<std::uint8_t>(all ^ (kFull + 1));
      any = static_cast<std::uint8_t>(any | odd[i]);
    }
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) {
      expected[first + i] = local_estimate(neighbours(sums, i, own[i]), full.per_count, full.per_degree, full.chance,
                                           own[i], floor[first + i], shot[first + i]);
    }
    if (any != 0) estimate_odd(sums, odd, count, good, own, floor + first, shot + first, n, expected + first);
  }
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

AlongRow along_row(const GeometryRow& g, int first) {
  const double x = g.x + first * g.x_step, y = g.y + first * g.y_step, z = g.z + first * g.z_step;
  return {x * x + y * y + z * z,
          2 * (x * g.x_step + y * g.y_step + z * g.z_step),
          g.x_step * g.x_step + g.y_step * g.y_step + g.z_step * g.z_step,
          z,
          g.z_step,
          1 / (g.area_m2 * g.facing)};
}

// 1/(1 + t) = (1 − t)(1 + t²)(1 + t⁴) to t⁸: below rounding for |t| up to this.
constexpr double kSmallChange = 7e-3;

}  // namespace

SCATMAP_CLONES void inverse_projected(const GeometryRow& g, int first, int pixels, double* out) {
  constexpr int kPart = 128;
  for (int begin = 0; begin < pixels; begin += kPart) {
    const int n = std::min(kPart, pixels - begin);
    const AlongRow at = along_row(g, first + begin);
    double* to = out + begin;
    const double half = 0.5 * (n - 1), per_z = 1 / (at.z + half * at.z_step), change = at.z_step * per_z;
    if (!(std::abs(change) * half <= kSmallChange)) {
      SCATMAP_INDEPENDENT
      for (int i = 0; i < n; ++i) {
        const double r2 = at.square + i * (at.linear + i * at.quadratic);
        to[i] = r2 * r2 * at.scale / (at.z + i * at.z_step);
      }
      continue;
    }
    const double scale = at.scale * per_z, start = -half * change;
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) {
      const double r2 = at.square + i * (at.linear + i * at.quadratic);
      const double t = start + i * change, t2 = t * t, low = (1 - t) + (1 - t) * t2;
      to[i] = r2 * r2 * scale * (low + low * (t2 * t2));
    }
  }
}

SCATMAP_CLONES bool brdf_strip(const CleanRow& in, const double* expected, const double* inverse_projected, int pixels,
                               const BrdfStrip& out) {
  constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();
  const double* value = in.value;
  const float *floor = in.floor, *shot = in.shot;
  double *brdf = out.brdf_per_sr, *expected_f = out.expected_per_sr;
  float* u_random = out.u_random_per_sr;
  std::int64_t largest = 0;  // bit pattern
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) {
    const double e = expected[i], inverse = inverse_projected[i], quotient = value[i] * inverse;
    brdf[i] = e == e ? quotient : kNaN;  // expected is NaN where the pixel is not good
    expected_f[i] = e * inverse;
    const auto level = static_cast<float>(e);
    const float u = std::sqrt(variance_at(level, floor[i], shot[i])) * static_cast<float>(inverse);
    u_random[i] = level == level ? u : kNoNumber;
    const std::int64_t bits = std::bit_cast<std::int64_t>(quotient) & kMagnitude;
    largest = bits > largest ? bits : largest;
  }
  return largest >= kInfinite;
}

}  // namespace scatmap
