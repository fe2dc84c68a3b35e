#include "scatmap/counts/row_kernels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "scatmap/base/simd.h"

namespace scatmap {

float float_at_or_above(double threshold) {
  const auto near = static_cast<float>(threshold);
  return near >= threshold ? near : std::nextafter(near, std::numeric_limits<float>::infinity());
}

namespace {

// Linearised values over a reference, or over 0 (nullptr); a polynomial is taken in double.
template <class T>
SCATMAP_INLINE void linearise(const float* raw, const float* reference, int n, const SensorModel& s, T* out) {
  if (s.linearity.empty()) {
    if (reference == nullptr) {
      SCATMAP_INDEPENDENT
      for (int i = 0; i < n; ++i) out[i] = static_cast<T>(raw[i]);
      return;
    }
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) out[i] = static_cast<T>(raw[i]) - static_cast<T>(reference[i]);
    return;
  }
  alignas(64) double change[kStrip];
  const double bias = s.bias_dn;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) change[i] = 0;
  for (auto c = s.linearity.rbegin(); c != s.linearity.rend(); ++c) {
    const double coefficient = *c;
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) change[i] = (change[i] + coefficient) * (static_cast<double>(raw[i]) - bias);
  }
  for (int i = 0; i < n; ++i) {
    const double from = reference == nullptr ? 0 : static_cast<double>(reference[i]);
    out[i] = static_cast<T>(bias - from + (static_cast<double>(raw[i]) - bias) * (1 + change[i]));
  }
}

// Whether a strip may hold a value at saturation or NaN: by bit patterns, which order as magnitudes do, NaN past all.
SCATMAP_INLINE bool may_need_marks(const float* raw, int n, float saturation) {
  std::int32_t largest = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const std::int32_t bits = std::bit_cast<std::int32_t>(raw[i]) & 0x7fffffff;
    largest = bits > largest ? bits : largest;
  }
  return !(saturation > 0 && largest < std::bit_cast<std::int32_t>(saturation));
}

// Adds a row's marks to those of the rows before.
template <class T>
SCATMAP_INLINE void mark_raw(const float* raw, int n, float saturation, StripSums<T>& s) {
  if (!may_need_marks(raw, n, saturation)) return;
  Mask* mask = s.mask;
  if (!s.marked) std::fill_n(mask, n, Mask{0});
  s.marked = true;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const Mask saturated = raw[i] >= saturation ? kSaturated : Mask{0};
    const Mask absent = raw[i] != raw[i] ? kNoData : Mask{0};
    mask[i] = static_cast<Mask>(mask[i] | saturated | absent);
  }
}

template <bool kDarks, class T>
SCATMAP_INLINE void sum(std::span<const float* const> raw, const float* reference, int n, const SensorModel& sensor,
                        StripSums<T>& s) {
  const float saturation = float_at_or_above(sensor.saturation_dn);
  s.marked = false;
  linearise(raw[0], reference, n, sensor, s.first);
  mark_raw(raw[0], n, saturation, s);
  alignas(64) T value[kStrip];
  for (std::size_t k = 1; k < raw.size(); ++k) {
    linearise(raw[k], reference, n, sensor, value);
    mark_raw(raw[k], n, saturation, s);
    if (k == 1) {
      SCATMAP_INDEPENDENT
      for (int i = 0; i < n; ++i) {
        const T d = value[i] - s.first[i];
        s.sum[i] = d;
        s.least[i] = d < 0 ? d : 0;
        s.largest[i] = d > 0 ? d : 0;
        if constexpr (kDarks) s.square[i] = d * d;
      }
      continue;
    }
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) {
      const T d = value[i] - s.first[i];
      s.sum[i] += d;
      s.least[i] = d < s.least[i] ? d : s.least[i];
      s.largest[i] = d > s.largest[i] ? d : s.largest[i];
      if constexpr (kDarks) s.square[i] += d * d;
    }
  }
}

// Below 1: rounding must not pass what the judge would reject. In float the values' own rounding is some 1e-6 of the
// least limit, which the drift allowance sets.
template <class T>
constexpr T kCautious = static_cast<T>(sizeof(T) == sizeof(double) ? 1 - 1e-9 : 1 - 1e-5);

template <bool kFlat, bool kOne, class T>
SCATMAP_INLINE void mean_rate(const StripSums<T>& s, const StripInputs& in, const ReduceConstants& k, int n,
                              const CountsRow<T>& out) {
  const auto per_frame = static_cast<T>(1 / k.frames), exposure_s = static_cast<T>(k.exposure_s),
             uniform = static_cast<T>(1 / k.exposure_s), per_e = static_cast<T>(1 / (k.gain_e_per_dn * k.frames));
  const float *single = in.single_variance, *of_level = in.level_variance, *flat = in.flat;
  T* rate = out.rate;
  float *frame_floor = out.frame_floor, *shot = out.shot, *dark_floor = out.dark_floor;
  const auto per_s_at = [=](int i) {
    if constexpr (kFlat) return 1 / (exposure_s * static_cast<T>(flat[i]));
    return uniform;
  };
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const T per_s = per_s_at(i), net = kOne ? s.first[i] : s.first[i] + s.sum[i] * per_frame;
    rate[i] = net * per_s;
    shot[i] = static_cast<float>(per_s * per_e);
  }
  if (dark_floor == nullptr) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) {
      const T per_s = per_s_at(i), both = static_cast<T>(single[i]) * per_frame + static_cast<T>(of_level[i]);
      frame_floor[i] = static_cast<float>(both * per_s * per_s);
    }
    return;
  }
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const T per_s = per_s_at(i);
    frame_floor[i] = static_cast<float>(static_cast<T>(single[i]) * (per_frame * (per_s * per_s)));
    dark_floor[i] = static_cast<float>(static_cast<T>(of_level[i]) * (per_s * per_s));
  }
}

// Marks what the frames' noise model at the least value does not explain. @return whether any
template <class T>
SCATMAP_INLINE int mark_doubtful(StripSums<T>& s, const StripInputs& in, const ReduceConstants& k, int n) {
  const bool one = k.frames < 2;
  if (one && !s.marked) return 0;
  const auto per_gain = static_cast<T>(1 / k.gain_e_per_dn), drift2 = static_cast<T>(k.drift2),
             sigmas2 = static_cast<T>(k.sigmas2) * kCautious<T>;
  const float* single = in.single_variance;
  std::uint8_t any = 0;
  if (!one) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) {
      const T least = s.first[i] + s.least[i], net = least > 0 ? least : 0;
      const T limit2 = sigmas2 * (static_cast<T>(single[i]) + net * per_gain + drift2 * (net * net));
      const T range = s.largest[i] - s.least[i];
      s.doubtful[i] = range * range <= limit2 ? 0 : 1;
    }
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) any = static_cast<std::uint8_t>(any | s.doubtful[i]);
  }
  if (!s.marked) return any;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const auto absent = static_cast<std::uint8_t>((s.mask[i] & kNoData) != 0 ? 1 : 0);
    s.doubtful[i] = one ? absent : static_cast<std::uint8_t>(s.doubtful[i] | absent);
    any = static_cast<std::uint8_t>(any | s.doubtful[i]);
  }
  return any;
}

// @param raw nullptr: none is marked
SCATMAP_INLINE void response_mask(const StripInputs& in, const Mask* raw, int n, Mask* out) {
  std::copy_n(in.dark_mask, n, out);
  if (raw != nullptr) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) out[i] = static_cast<Mask>(out[i] | raw[i]);
  }
  if (in.bad != nullptr) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) out[i] = static_cast<Mask>(out[i] | in.bad[i]);
  }
  if (in.flat != nullptr) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) out[i] = static_cast<Mask>(out[i] | (in.flat[i] > 0 ? Mask{0} : kFlatInvalid));
  }
}

template <class T>
SCATMAP_INLINE bool reduce(StripSums<T>& sums, const StripInputs& in, const ReduceConstants& k, int pixels,
                           const CountsRow<T>& out) {
  response_mask(in, sums.marked ? sums.mask : nullptr, pixels, out.mask);
  const bool one = k.frames < 2;
  if (in.flat != nullptr) {
    one ? mean_rate<true, true>(sums, in, k, pixels, out) : mean_rate<true, false>(sums, in, k, pixels, out);
  } else {
    one ? mean_rate<false, true>(sums, in, k, pixels, out) : mean_rate<false, false>(sums, in, k, pixels, out);
  }
  return mark_doubtful(sums, in, k, pixels) != 0;
}

}  // namespace

SCATMAP_CLONES void sum_frames(std::span<const float* const> raw, const float* reference, int pixels,
                               const SensorModel& sensor, StripSums<double>& sums) {
  sum<false>(raw, reference, pixels, sensor, sums);
}

SCATMAP_CLONES void sum_frames(std::span<const float* const> raw, const float* reference, int pixels,
                               const SensorModel& sensor, StripSums<float>& sums) {
  sum<false>(raw, reference, pixels, sensor, sums);
}

SCATMAP_CLONES void sum_darks(std::span<const float* const> raw, int pixels, const SensorModel& sensor,
                              StripSums<double>& sums) {
  sum<true>(raw, nullptr, pixels, sensor, sums);
}

SCATMAP_CLONES bool reduce_strip(StripSums<double>& sums, const StripInputs& in, const ReduceConstants& k, int pixels,
                                 const CountsRow<double>& out) {
  return reduce(sums, in, k, pixels, out);
}

SCATMAP_CLONES bool reduce_strip(StripSums<float>& sums, const StripInputs& in, const ReduceConstants& k, int pixels,
                                 const CountsRow<float>& out) {
  return reduce(sums, in, k, pixels, out);
}

SCATMAP_CLONES bool dark_strip(StripSums<double>& s, const DarkConstants& k, int pixels, float* level,
                               float* sample_variance) {
  const double per_dark = 1 / k.darks;
  const double per_degree = k.darks > 1 ? 1 / (k.darks - 1) : std::numeric_limits<double>::quiet_NaN();
  const double sigmas2 = (k.darks >= 3 ? k.sigmas2 : std::numeric_limits<double>::infinity()) * kCautious<double>;
  const double floor_dn2 = k.floor_dn2, bias = k.bias_dn, per_gain = 1 / k.gain_e_per_dn;
  if (k.darks < 2) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < pixels; ++i) s.sum[i] = s.square[i] = s.least[i] = s.largest[i] = 0;
  }
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) {
    level[i] = static_cast<float>(s.first[i] + s.sum[i] * per_dark);
    const double squares = s.square[i] - s.sum[i] * s.sum[i] * per_dark;
    sample_variance[i] = static_cast<float>((squares > 0 ? squares : 0) * per_degree);
    const double above = s.first[i] + s.least[i] - bias;
    const double limit2 = sigmas2 * (floor_dn2 + (above > 0 ? above : 0) * per_gain);
    const double range = s.largest[i] - s.least[i];
    s.doubtful[i] = range * range <= limit2 ? 0 : 1;
  }
  if (s.marked) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < pixels; ++i)
      s.doubtful[i] = static_cast<std::uint8_t>(s.doubtful[i] | ((s.mask[i] & kNoData) != 0 ? 1 : 0));
  }
  std::uint8_t any = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) any = static_cast<std::uint8_t>(any | s.doubtful[i]);
  return any != 0;
}

SCATMAP_CLONES void finish_dark_row(const float* level, const float* count, const float* sample_variance, int pixels,
                                    const FinishConstants& k, float* single_variance, float* level_variance,
                                    Mask* mask) {
  const double pooled = k.pooled, typical = k.typical, per_gain = 1 / k.gain_e_per_dn, hot_above = k.hot_above;
  const double extra2 = k.extra_sigmas * k.extra_sigmas * pooled, least = 0.5 * pooled, ratio = k.unstable_ratio;
  const double fewest = k.darks < 4 ? -1 : k.darks - 2;  // that many left, or fewer: it flickers
  const double most = k.darks < 4 ? std::numeric_limits<double>::infinity() : ratio;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) {
    const double n = count[i], excess = static_cast<double>(level[i]) - typical;
    const double raised = pooled + (excess * excess * n > extra2 ? excess * per_gain : 0);
    const double variance = raised > least ? raised : least;
    single_variance[i] = static_cast<float>(variance);
    level_variance[i] = static_cast<float>(variance / n);
    // Level NaN is hot; a scatter that is NaN (one dark) says nothing.
    const double scatter = sample_variance[i];
    const int steady = (static_cast<double>(level[i]) <= hot_above ? 1 : 0) & (n > fewest ? 1 : 0) &
                       (scatter > most * variance ? 0 : 1);
    mask[i] = steady != 0 ? Mask{0} : kHot;
  }
}

SCATMAP_CLONES PooledRow pooled_row(const float* level, const float* value, int pixels, double typical, double limit) {
  constexpr int kLanes = 16;  // as below
  double sum[kLanes] = {}, count[kLanes] = {};
  const auto add = [&](int i, int k) {
    const double off = std::abs(static_cast<double>(level[i]) - typical), v = value[i];
    const bool counts = off <= limit && v - v == 0;
    sum[k] += counts ? v : 0;
    count[k] += counts ? 1 : 0;
  };
  int first = 0;
  for (; first + kLanes <= pixels; first += kLanes) {
    SCATMAP_INDEPENDENT
    for (int k = 0; k < kLanes; ++k) add(first + k, k);
  }
  for (; first < pixels; ++first) add(first, 0);
  PooledRow out{0, 0};
  for (int k = 0; k < kLanes; ++k) {
    out.sum += sum[k];
    out.count += count[k];
  }
  return out;
}

SCATMAP_CLONES bool spills_charge(std::span<const Mask> row) {
  Mask any = 0;
  for (std::size_t c = 0; c < row.size(); ++c)
    any = static_cast<Mask>(any | ((row[c] & (kSaturated | kHot)) == kSaturated ? 1 : 0));
  return any != 0;
}

SCATMAP_CLONES RowLight row_light(const float* raw, int pixels) {
  constexpr int kLanes = 32;  // sums of their own, which may be added in any order that is always the same
  double sum[kLanes] = {};
  float largest[kLanes];
  for (float& lane : largest) lane = -std::numeric_limits<float>::infinity();
  int first = 0;
  for (; first + kLanes <= pixels; first += kLanes) {
    SCATMAP_INDEPENDENT
    for (int k = 0; k < kLanes; ++k) {
      const float v = raw[first + k];
      sum[k] += v == v ? v : 0.f;
      largest[k] = v > largest[k] ? v : largest[k];
    }
  }
  for (int k = 0; first + k < pixels; ++k) {
    const float v = raw[first + k];
    sum[k] += v == v ? v : 0.f;
    largest[k] = v > largest[k] ? v : largest[k];
  }
  RowLight out{0, largest[0]};
  for (int k = 0; k < kLanes; ++k) {
    out.sum += sum[k];
    out.largest = std::max(out.largest, largest[k]);
  }
  return out;
}

SCATMAP_CLONES void mean_row(std::span<const float* const> rows, int pixels, float* mean) {
  const auto share = static_cast<float>(1 / static_cast<double>(rows.size()));
  std::fill_n(mean, pixels, 0.f);
  for (const float* row : rows) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < pixels; ++i) mean[i] += row[i] * share;
  }
}

namespace {

// Sums of float values, in lanes as above.
SCATMAP_INLINE double sum_of(const float* values, int n) {
  constexpr int kLanes = 16;
  double lanes[kLanes] = {};
  int first = 0;
  for (; first + kLanes <= n; first += kLanes) {
    SCATMAP_INDEPENDENT
    for (int k = 0; k < kLanes; ++k) lanes[k] += static_cast<double>(values[first + k]);
  }
  double sum = 0;
  for (; first < n; ++first) sum += static_cast<double>(values[first]);
  for (const double lane : lanes) sum += lane;
  return sum;
}

}  // namespace

SCATMAP_CLONES RowChange row_change(const float* mean, const float* other, const float* dark,
                                    const float* single_variance, const Mask* dark_mask, int pixels,
                                    const ChangeLimits& limits) {
  const auto per_gain = static_cast<float>(limits.per_gain), bright2 = static_cast<float>(limits.bright2),
             differing2 = static_cast<float>(limits.differing2), drift2 = static_cast<float>(limits.drift2);
  alignas(64) float net[kStrip], variance[kStrip], bright[kStrip], differing[kStrip];
  RowChange out;
  for (int first = 0; first < pixels; first += kStrip) {
    const int n = std::min(kStrip, pixels - first);
    const float *m = mean + first, *o = other + first, *level = dark + first, *single = single_variance + first;
    const Mask* mask = dark_mask + first;
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) {
      const float a = m[i] - level[i], given = o[i] - level[i], b = given - given == 0 ? given : 0, d = b - a;
      const float light = a > 0 ? a : 0, noise2 = single[i] + light * per_gain, light2 = light * light;
      const float counts = light2 > bright2 * noise2 ? 1 : 0;
      const float known = (given - given == 0 ? counts : 0) * (mask[i] == 0 ? 1.f : 0.f);
      net[i] = known * b;
      variance[i] = known > 0 ? noise2 : 0;
      bright[i] = known;
      differing[i] = d * d > differing2 * (noise2 + drift2 * light2) ? known : 0;
    }
    out.net_dn += sum_of(net, n);
    out.noise2 += sum_of(variance, n);
    out.bright += sum_of(bright, n);
    out.differing += sum_of(differing, n);
  }
  return out;
}

}  // namespace scatmap
