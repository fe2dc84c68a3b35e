#include "scatmap/counts/row_kernels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scatmap/base/simd.h"

namespace scatmap {

float float_at_or_above(double threshold) {
  const auto near = static_cast<float>(threshold);
  return near >= threshold ? near : std::nextafter(near, std::numeric_limits<float>::infinity());
}

namespace {

SCATMAP_INLINE void linearise(const float* raw, int n, const SensorModel& s, double* out) {
  const double bias = s.bias_dn;
  if (s.linearity.empty()) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) out[i] = bias + (static_cast<double>(raw[i]) - bias);
    return;
  }
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) out[i] = 0;
  for (auto c = s.linearity.rbegin(); c != s.linearity.rend(); ++c) {
    const double coefficient = *c;
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) out[i] = (out[i] + coefficient) * (static_cast<double>(raw[i]) - bias);
  }
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) out[i] = bias + (static_cast<double>(raw[i]) - bias) * (1 + out[i]);
}

template <bool kFirst>
SCATMAP_INLINE void mark_raw(const float* raw, int n, float saturation, Mask* mask) {
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const Mask saturated = raw[i] >= saturation ? kSaturated : Mask{0};
    const Mask absent = raw[i] != raw[i] ? kNoData : Mask{0};
    mask[i] = static_cast<Mask>((kFirst ? Mask{0} : mask[i]) | saturated | absent);
  }
}

template <bool kDarks>
SCATMAP_INLINE void sum(std::span<const float* const> raw, int n, const SensorModel& sensor, StripSums& s) {
  const float saturation = float_at_or_above(sensor.saturation_dn);
  linearise(raw[0], n, sensor, s.first);
  mark_raw<true>(raw[0], n, saturation, s.mask);
  alignas(64) double value[kStrip];
  for (std::size_t k = 1; k < raw.size(); ++k) {
    linearise(raw[k], n, sensor, value);
    mark_raw<false>(raw[k], n, saturation, s.mask);
    if (k == 1) {
      SCATMAP_INDEPENDENT
      for (int i = 0; i < n; ++i) {
        const double d = value[i] - s.first[i];
        s.sum[i] = d;
        s.least[i] = d < 0 ? d : 0;
        s.largest[i] = d > 0 ? d : 0;
        if constexpr (kDarks) s.square[i] = d * d;
      }
      continue;
    }
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) {
      const double d = value[i] - s.first[i];
      s.sum[i] += d;
      s.least[i] = d < s.least[i] ? d : s.least[i];
      s.largest[i] = d > s.largest[i] ? d : s.largest[i];
      if constexpr (kDarks) s.square[i] += d * d;
    }
  }
}

// A hair below 1: rounding must not pass what the judge would reject.
constexpr double kCautious = 1 - 1e-9;

template <bool kFlat, bool kOne>
SCATMAP_INLINE void mean_rate(const StripSums& s, const StripInputs& in, const ReduceConstants& k, int n,
                              const CountsRow& out) {
  const double per_frame = 1 / k.frames, exposure_s = k.exposure_s, gain = k.gain_e_per_dn;
  const float *level = in.dark_level, *single = in.single_variance, *of_level = in.level_variance, *flat = in.flat;
  double* rate = out.rate;
  float *frame_floor = out.frame_floor, *shot = out.shot, *dark_floor = out.dark_floor;
  const auto per_s_at = [=](int i) {
    if constexpr (kFlat) return 1 / (exposure_s * static_cast<double>(flat[i]));
    return 1 / exposure_s;
  };
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const double per_s = per_s_at(i);
    const double mean = kOne ? s.first[i] : s.first[i] + s.sum[i] * per_frame;
    rate[i] = (mean - static_cast<double>(level[i])) * per_s;
  }
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) shot[i] = static_cast<float>(per_s_at(i) / gain * per_frame);
  if (dark_floor == nullptr) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) {
      const double per_s = per_s_at(i),
                   both = static_cast<double>(single[i]) * per_frame + static_cast<double>(of_level[i]);
      frame_floor[i] = static_cast<float>(both * (per_s * per_s));
    }
    return;
  }
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const double per_s = per_s_at(i);
    frame_floor[i] = static_cast<float>(static_cast<double>(single[i]) * (per_frame * (per_s * per_s)));
    dark_floor[i] = static_cast<float>(static_cast<double>(of_level[i]) * (per_s * per_s));
  }
}

// Marks what the frames' noise model at the least value does not explain. @return whether any
SCATMAP_INLINE int mark_doubtful(StripSums& s, const StripInputs& in, const ReduceConstants& k, int n) {
  const double per_gain = 1 / k.gain_e_per_dn, drift2 = k.drift2, sigmas2 = k.sigmas2 * kCautious;
  const float *level = in.dark_level, *single = in.single_variance;
  const bool one = k.frames < 2;
  for (int i = 0; !one && i < n; ++i) {
    const double above = s.first[i] + s.least[i] - static_cast<double>(level[i]);
    const double net = above > 0 ? above : 0;
    const double limit2 = sigmas2 * (static_cast<double>(single[i]) + net * per_gain + drift2 * (net * net));
    const double range = s.largest[i] - s.least[i];
    s.doubtful[i] = range * range <= limit2 ? 0 : 1;
  }
  Mask raw = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) raw = static_cast<Mask>(raw | s.mask[i]);
  if (one && (raw & kNoData) == 0) return 0;
  std::uint8_t any = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) {
    const auto absent = static_cast<std::uint8_t>((s.mask[i] & kNoData) != 0 ? 1 : 0);
    s.doubtful[i] = one ? absent : static_cast<std::uint8_t>(s.doubtful[i] | absent);
    any = static_cast<std::uint8_t>(any | s.doubtful[i]);
  }
  return any;
}

SCATMAP_INLINE void response_mask(const StripInputs& in, const Mask* raw, int n, Mask* out) {
  SCATMAP_INDEPENDENT
  for (int i = 0; i < n; ++i) out[i] = static_cast<Mask>(in.dark_mask[i] | raw[i]);
  if (in.bad != nullptr) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) out[i] = static_cast<Mask>(out[i] | in.bad[i]);
  }
  if (in.flat != nullptr) {
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) out[i] = static_cast<Mask>(out[i] | (in.flat[i] > 0 ? Mask{0} : kFlatInvalid));
  }
}

}  // namespace

SCATMAP_CLONES void sum_frames(std::span<const float* const> raw, int pixels, const SensorModel& sensor,
                               StripSums& sums) {
  sum<false>(raw, pixels, sensor, sums);
}

SCATMAP_CLONES void sum_darks(std::span<const float* const> raw, int pixels, const SensorModel& sensor,
                              StripSums& sums) {
  sum<true>(raw, pixels, sensor, sums);
}

SCATMAP_CLONES bool reduce_strip(StripSums& sums, const StripInputs& in, const ReduceConstants& k, int pixels,
                                 const CountsRow& out) {
  response_mask(in, sums.mask, pixels, out.mask);
  const bool flat = in.flat != nullptr, one = k.frames < 2;
  if (flat) {
    one ? mean_rate<true, true>(sums, in, k, pixels, out) : mean_rate<true, false>(sums, in, k, pixels, out);
  } else {
    one ? mean_rate<false, true>(sums, in, k, pixels, out) : mean_rate<false, false>(sums, in, k, pixels, out);
  }
  return mark_doubtful(sums, in, k, pixels) != 0;
}

SCATMAP_CLONES bool dark_strip(StripSums& s, const DarkConstants& k, int pixels, float* level, float* sample_variance) {
  const double per_dark = 1 / k.darks;
  const double per_degree = k.darks > 1 ? 1 / (k.darks - 1) : std::numeric_limits<double>::quiet_NaN();
  const double sigmas2 = (k.darks >= 3 ? k.sigmas2 : std::numeric_limits<double>::infinity()) * kCautious;
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
  std::uint8_t any = 0;
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) {
    s.doubtful[i] = static_cast<std::uint8_t>(s.doubtful[i] | ((s.mask[i] & kNoData) != 0 ? 1 : 0));
    any = static_cast<std::uint8_t>(any | s.doubtful[i]);
  }
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

}  // namespace scatmap
