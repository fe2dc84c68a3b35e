#pragma once
#include <cstdint>
#include <span>

#include "scatmap/counts/sensor_model.h"

/// The vector loops of reduce and combine_darks, on strips of a row that stay in the first-level cache. A strip's pixel
/// is settled here unless its values scatter so much that one of them might be an outlier: such pixels are marked, and
/// the caller judges them one by one. The marking is conservative: what it passes has no outlier.
namespace scatmap {

inline constexpr int kStrip = 256;

/// What several linearised raw rows say of each pixel of a strip. float: within some 1e-7 of each value over its
/// reference.
template <class T>
struct StripSums {
  alignas(64) T first[kStrip];    ///< of the first row, over the reference
  alignas(64) T sum[kStrip];      ///< of (value − first); this and what follows only with two rows or more
  alignas(64) T square[kStrip];   ///< of (value − first)², for darks only
  alignas(64) T least[kStrip];    ///< of (value − first)
  alignas(64) T largest[kStrip];  ///< of (value − first)
  alignas(64) Mask mask[kStrip];  ///< kSaturated, kNoData: any raw value at saturation, or NaN; only where `marked`
  alignas(64) std::uint8_t doubtful[kStrip];
  bool marked;  ///< whether any mask is not 0
};

/// Least float at or above a threshold, so that comparing floats decides as comparing doubles does.
float float_at_or_above(double threshold);

/// @param raw one pointer per frame; @param reference the dark level; @param pixels at most kStrip
void sum_frames(std::span<const float* const> raw, const float* reference, int pixels, const SensorModel& sensor,
                StripSums<double>& sums);
void sum_frames(std::span<const float* const> raw, const float* reference, int pixels, const SensorModel& sensor,
                StripSums<float>& sums);
/// Over a reference of 0.
void sum_darks(std::span<const float* const> raw, int pixels, const SensorModel& sensor, StripSums<double>& sums);

/// Where a strip of a master dark and of a pixel response stands; nullptr where there is none.
struct StripInputs {
  const float* single_variance;
  const float* level_variance;
  const Mask* dark_mask;
  const Mask* bad;
  const float* flat;
};

/// Where a row or strip of Counts goes (reduce.h).
template <class T>
struct CountsRow {
  T* rate;
  float* frame_floor;
  float* shot;
  float* dark_floor;  ///< nullptr: added to frame_floor
  Mask* mask;
};

struct ReduceConstants {
  double frames, exposure_s;
  double gain_e_per_dn;
  double drift2, sigmas2;  ///< squares of the drift allowance and of the outlier limit
};

/// Fills `out`, and sums.doubtful. @return whether any pixel is doubtful
bool reduce_strip(StripSums<double>& sums, const StripInputs& in, const ReduceConstants& k, int pixels,
                  const CountsRow<double>& out);
bool reduce_strip(StripSums<float>& sums, const StripInputs& in, const ReduceConstants& k, int pixels,
                  const CountsRow<float>& out);

struct DarkConstants {
  double darks, floor_dn2, bias_dn, gain_e_per_dn, sigmas2;
};

/// Level and sample variance of a strip of darks (variance NaN with one dark), and sums.doubtful. @return whether any
/// pixel is doubtful
bool dark_strip(StripSums<double>& sums, const DarkConstants& k, int pixels, float* level, float* sample_variance);

struct FinishConstants {
  double darks, pooled, typical, hot_above, gain_e_per_dn, extra_sigmas, unstable_ratio;
};

/// Expected variances and kHot of a row of darks (dark.cpp). @param count darks kept per pixel
void finish_dark_row(const float* level, const float* count, const float* sample_variance, int pixels,
                     const FinishConstants& k, float* single_variance, float* level_variance, Mask* mask);

/// Of the finite values whose level is within `limit` of the typical one.
struct PooledRow {
  double sum, count;
};
PooledRow pooled_row(const float* level, const float* value, int pixels, double typical, double limit);

/// Whether a row of masks holds a pixel that light has saturated: its charge spills into its neighbours. A hot pixel is
/// alone.
bool spills_charge(std::span<const Mask> row);

/// Sum and largest of a row of raw values; NaN counts as absent.
struct RowLight {
  double sum;
  float largest;  ///< −infinity where there is none
};
RowLight row_light(const float* raw, int pixels);

void mean_row(std::span<const float* const> rows, int pixels, float* mean);

/// frame_steadiness.h, along a row. Squares of sigmas and shares.
struct ChangeLimits {
  double per_gain, bright2, differing2, drift2;
};
struct RowChange {
  double net_dn = 0, bright = 0, differing = 0;
  double noise2 = 0;  ///< of the bright pixels' sum
};
RowChange row_change(const float* mean, const float* other, const float* dark, const float* single_variance,
                     const Mask* dark_mask, int pixels, const ChangeLimits& limits);

}  // namespace scatmap
