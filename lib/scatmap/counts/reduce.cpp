#include "scatmap/counts/reduce.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/parallel_rows.h"

namespace scatmap {
namespace {

void check_frames(std::span<const Frame> frames, const MasterDark& dark, double exposure_s) {
  if (frames.empty()) throw Error({"frames", "no frame", {}, {}});
  constexpr double kSameTime = 1e-3;  // header times are rounded by camera drivers
  for (const Frame& f : frames) {
    require_same_shape(frames.front(), f);
    if (f.header.exposure_s && !(std::abs(*f.header.exposure_s - exposure_s) <= kSameTime * exposure_s)) {
      throw Error({f.file.string() + ": EXPTIME", "contradicts exposure_s of the measurement",
                   number_text(*f.header.exposure_s) + " s", number_text(exposure_s) + " s"});
    }
  }
  if (!frames.front().dn.same_shape(dark.level_dn)) {
    throw Error({frames.front().file.string(), "and its darks differ in size", {}, {}});
  }
}

struct PixelMean {
  double mean_dn = 0;
  int count = 0;
  bool saturated = false;
};

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Mean of the frames at one pixel, outliers judged against the noise model at the median.
PixelMean combine(const std::vector<double>& values, double dark_dn, double single_variance,
                  const SensorModel& sensor) {
  double centre = 0, limit = std::numeric_limits<double>::infinity();
  if (values.size() >= 2) {
    centre = values.size() == 2 ? std::min(values[0], values[1]) : median_of(values);
    const double net = std::max(0.0, centre - dark_dn);
    const double drift = kFrameDriftAllowance * net;
    limit = kFrameOutlierSigmas * std::sqrt(single_variance + net / sensor.gain_e_per_dn + drift * drift);
    if (values.size() == 2) limit *= std::sqrt(2.0);
  }
  PixelMean out;
  double sum = 0;
  for (const double v : values) {
    if (std::abs(v - centre) <= limit) {
      sum += v;
      ++out.count;
    }
  }
  if (values.size() == 2 && out.count == 1) out.count = 0;  // two values that disagree: neither can be trusted
  out.mean_dn = sum / out.count;
  return out;
}

// Charge of a pixel that light has saturated spills into its neighbours; a hot pixel is alone.
void mask_bloom(Grid<Mask>& mask) {
  const int rows = mask.rows(), columns = mask.columns();
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      if ((mask(r, c) & (kSaturated | kHot)) != kSaturated) continue;
      for (int dr = -1; dr <= 1; ++dr) {
        for (int dc = -1; dc <= 1; ++dc) {
          const int rr = r + dr, cc = c + dc;
          if (rr < 0 || rr >= rows || cc < 0 || cc >= columns) continue;
          if ((mask(rr, cc) & kSaturated) == 0) mask(rr, cc) |= kBloom;
        }
      }
    }
  }
}

Mask response_mask(const PixelResponse& response, int row, int column) {
  Mask m = response.bad.empty() ? Mask{0} : response.bad(row, column);
  if (!response.flat.empty() && !(response.flat(row, column) > 0)) m |= kFlatInvalid;
  return m;
}

}  // namespace

Counts reduce(std::span<const Frame> frames, const MasterDark& dark, const SensorModel& sensor,
              const PixelResponse& response, double exposure_s) {
  check_frames(frames, dark, exposure_s);
  const int rows = frames.front().dn.rows(), columns = frames.front().dn.columns();
  Counts out{{rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}, exposure_s, 0, 0};
  std::atomic<std::size_t> saturated{0}, rejected{0};
  for_each_row(rows, [&](int row) {
    std::vector<double> values(frames.size());
    std::size_t saturated_here = 0, rejected_here = 0;
    for (int c = 0; c < columns; ++c) {
      Mask mask = static_cast<Mask>(dark.mask(row, c) | response_mask(response, row, c));
      for (std::size_t k = 0; k < frames.size(); ++k) {
        const double raw = frames[k].dn(row, c);
        if (raw >= sensor.saturation_dn) mask |= kSaturated;
        if (std::isnan(raw)) mask |= kNoData;
        values[k] = sensor.linearised(raw);
      }
      const PixelMean m = combine(values, dark.level_dn(row, c), dark.single_variance_dn2(row, c), sensor);
      if (m.count == 0 && (mask & kNoData) == 0) mask |= kCosmic;
      saturated_here += (mask & kSaturated) != 0;
      rejected_here += values.size() - static_cast<std::size_t>(m.count);
      const double flat = response.flat.empty() ? 1 : response.flat(row, c);
      const double per_s = 1 / (exposure_s * flat), n = m.count;
      out.rate_dn_per_s(row, c) = (m.mean_dn - dark.level_dn(row, c)) * per_s;
      out.frame_floor(row, c) = static_cast<float>(dark.single_variance_dn2(row, c) / n * per_s * per_s);
      out.shot(row, c) = static_cast<float>(per_s / (sensor.gain_e_per_dn * n));
      out.dark_floor(row, c) = static_cast<float>(dark.level_variance_dn2(row, c) * per_s * per_s);
      out.mask(row, c) = mask;
    }
    saturated += saturated_here;
    rejected += rejected_here;
  });
  mask_bloom(out.mask);
  out.saturated_pixels = saturated;
  out.rejected_values = rejected;
  return out;
}

}  // namespace scatmap
