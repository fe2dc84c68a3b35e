#include "scatmap/brdf/map_rows.h"

#include <algorithm>
#include <cmath>

#include "scatmap/base/simd.h"

namespace scatmap {
namespace {

constexpr int kLanes = 16;  // sums and maxima of their own, combined in an order that is always the same
constexpr double kSigmas = 10;

struct Lanes {
  double good[kLanes] = {}, sum[kLanes] = {}, count[kLanes] = {}, largest[kLanes];
};

SCATMAP_INLINE void add(const double* f, const float* u, const Mask* mask, int i, int k, Lanes& s) {
  const double value = f[i], of = u[i];
  const bool good = mask[i] == 0, clear = good && value > kSigmas * of;
  s.good[k] += good ? 1 : 0;
  s.largest[k] = good && value > s.largest[k] ? value : s.largest[k];
  s.sum[k] += clear ? of / value : 0;
  s.count[k] += clear ? 1 : 0;
}

}  // namespace

SCATMAP_CLONES void norm_of_rows(std::span<const float* const> parts, int pixels, float* out) {
  constexpr int kPart = 256;
  double sum[kPart];
  for (int first = 0; first < pixels; first += kPart) {
    const int n = std::min(kPart, pixels - first);
    for (int i = 0; i < n; ++i) sum[i] = 0;
    for (const float* part : parts) {
      const float* u = part + first;
      SCATMAP_INDEPENDENT
      for (int i = 0; i < n; ++i) sum[i] += static_cast<double>(u[i]) * static_cast<double>(u[i]);
    }
    SCATMAP_INDEPENDENT
    for (int i = 0; i < n; ++i) out[first + i] = static_cast<float>(std::sqrt(sum[i]));
  }
}

SCATMAP_CLONES RowSummary summarise_row(const double* f, const float* u, const Mask* mask, int pixels) {
  Lanes lanes;
  for (double& largest : lanes.largest) largest = -HUGE_VAL;
  int first = 0;
  for (; first + kLanes <= pixels; first += kLanes) {
    SCATMAP_INDEPENDENT
    for (int k = 0; k < kLanes; ++k) add(f, u, mask, first + k, k, lanes);
  }
  for (; first < pixels; ++first) add(f, u, mask, first, 0, lanes);
  RowSummary out{0, -HUGE_VAL, 0, 0};
  for (int k = 0; k < kLanes; ++k) {
    out.good += lanes.good[k];
    out.largest = std::max(out.largest, lanes.largest[k]);
    out.sum += lanes.sum[k];
    out.count += lanes.count[k];
  }
  return out;
}

SCATMAP_CLONES void add_good(const double* value, const Mask* mask, int pixels, double* sum, double* count) {
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) {
    sum[i] += mask[i] == 0 ? value[i] : 0;
    count[i] += mask[i] == 0 ? 1 : 0;
  }
}

SCATMAP_CLONES double largest_mean_of_three(const double* sum, const double* count, int means) {
  double largest[kLanes];
  for (double& lane : largest) lane = -HUGE_VAL;
  const auto mean = [&](int i) {
    return (sum[i] + sum[i + 1] + sum[i + 2]) / (count[i] + count[i + 1] + count[i + 2]);
  };
  int first = 0;
  for (; first + kLanes <= means; first += kLanes) {
    SCATMAP_INDEPENDENT
    for (int k = 0; k < kLanes; ++k) {
      const double m = mean(first + k);
      largest[k] = m > largest[k] ? m : largest[k];  // not where it is NaN
    }
  }
  for (; first < means; ++first) largest[0] = mean(first) > largest[0] ? mean(first) : largest[0];
  return *std::max_element(largest, largest + kLanes);
}

}  // namespace scatmap
