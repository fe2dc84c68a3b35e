#include "scatmap/counts/reduce.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/parallel.h"

namespace scatmap {

void require_reducible(std::span<const Frame> frames, const MasterDark& dark, double exposure_s) {
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

namespace {

struct PixelMean {
  double mean_dn = 0;
  int count = 0;
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

bool spills(Mask m) { return (m & (kSaturated | kHot)) == kSaturated; }

// Marking leaves the bits that it is decided by alone, so rows may come in any order.
void mask_bloom(Grid<Mask>& mask) {
  for (int r = 0; r < mask.rows(); ++r) {
    const std::span<const Mask> row = std::as_const(mask).row(r);
    if (!spills_charge(row)) continue;
    for (int rr = std::max(0, r - 1); rr <= std::min(mask.rows() - 1, r + 1); ++rr) mark_bloom(row, mask.row(rr));
  }
}

}  // namespace

void mark_bloom(std::span<const Mask> from, std::span<Mask> onto) {
  for (std::size_t c = 0; c < from.size(); ++c) {
    if (!spills(from[c])) continue;
    for (std::size_t k = c > 0 ? c - 1 : 0; k < std::min(from.size(), c + 2); ++k) {
      if ((onto[k] & kSaturated) == 0) onto[k] |= kBloom;
    }
  }
}

// One pixel whose values need judging.
template <class T>
std::size_t RowReducer<T>::judge(int row, int column, std::vector<double>& values, const CountsRow<T>& out,
                                 int at) const {
  for (std::size_t k = 0; k < frames_.size(); ++k) values[k] = sensor_.linearised(frames_[k].dn(row, column));
  const double dark = dark_.level_dn(row, column), single = dark_.single_variance_dn2(row, column);
  const PixelMean m = combine(values, dark, single, sensor_);
  Mask& mask = out.mask[at];
  if (m.count == 0 && (mask & kNoData) == 0) mask |= kCosmic;
  const double flat = response_.flat.empty() ? 1 : response_.flat(row, column);
  const double per_s = 1 / (exposure_s_ * flat), n = m.count;
  out.rate[at] = static_cast<T>((m.mean_dn - dark) * per_s);
  const double frame_floor = single / n * per_s * per_s;
  const double dark_floor = dark_.level_variance_dn2(row, column) * per_s * per_s;
  out.frame_floor[at] = static_cast<float>(out.dark_floor == nullptr ? frame_floor + dark_floor : frame_floor);
  out.shot[at] = static_cast<float>(per_s / (sensor_.gain_e_per_dn * n));
  return values.size() - static_cast<std::size_t>(m.count);
}

template <class T>
typename RowReducer<T>::Found RowReducer<T>::columns(int row, int first, int last, const CountsRow<T>& out,
                                                     Scratch& scratch) const {
  const double pair = frames_.size() == 2 ? 2 : 1;  // two frames differ by twice the variance of one
  const ReduceConstants k{static_cast<double>(frames_.size()), exposure_s_, sensor_.gain_e_per_dn,
                          kFrameDriftAllowance * kFrameDriftAllowance,
                          pair * kFrameOutlierSigmas * kFrameOutlierSigmas};
  scratch.values.resize(frames_.size());
  scratch.raw.resize(frames_.size());
  scratch.buffer.resize(frames_.size() * kStrip);
  StripSums<T>& sums = *scratch.sums;
  Found found{0, false};
  for (int c = first; c < last; c += kStrip) {
    const int pixels = std::min(kStrip, last - c), at = c - first;
    for (std::size_t i = 0; i < frames_.size(); ++i)
      scratch.raw[i] = frames_[i].dn.part(row, c, pixels, scratch.buffer.data() + i * kStrip);
    sum_frames(scratch.raw, &dark_.level_dn(row, c), pixels, sensor_, sums);
    const StripInputs in{&dark_.single_variance_dn2(row, c), &dark_.level_variance_dn2(row, c), &dark_.mask(row, c),
                         response_.bad.empty() ? nullptr : &response_.bad(row, c),
                         response_.flat.empty() ? nullptr : &response_.flat(row, c)};
    const CountsRow<T> strip{out.rate + at, out.frame_floor + at, out.shot + at,
                             out.dark_floor == nullptr ? nullptr : out.dark_floor + at, out.mask + at};
    found.saturated = found.saturated || sums.marked;
    if (!reduce_strip(sums, in, k, pixels, strip)) continue;
    for (int i = 0; i < pixels; ++i) {
      if (sums.doubtful[i] != 0) found.rejected += judge(row, c + i, scratch.values, out, at + i);
    }
  }
  return found;
}

namespace {

// Past the row's end is harmless: that is the next row, or an address that is not asked for.
template <class T>
void prefetch_part(const Grid<T>& plane, int row, int first, int last) {
  constexpr int kLine = 64 / sizeof(T);
  if (plane.empty()) return;
  const T* from = plane.row(row).data();
  for (int c = first; c < last; c += kLine) __builtin_prefetch(from + c, 0, 2);
}

}  // namespace

template <class T>
void RowReducer<T>::prefetch(int row, int first, int last) const {
  for (const Frame& frame : frames_) frame.dn.prefetch(row, first, last);
  prefetch_part(dark_.level_dn, row, first, last);
  prefetch_part(dark_.single_variance_dn2, row, first, last);
  prefetch_part(dark_.level_variance_dn2, row, first, last);
  prefetch_part(dark_.mask, row, first, last);
  prefetch_part(response_.flat, row, first, last);
}

template class RowReducer<double>;
template class RowReducer<float>;

Counts reduce(std::span<const Frame> frames, const MasterDark& dark, const SensorModel& sensor,
              const PixelResponse& response, double exposure_s) {
  require_reducible(frames, dark, exposure_s);
  const RowReducer<double> reducer(frames, dark, sensor, response, exposure_s);
  const int rows = frames.front().dn.rows(), columns = frames.front().dn.columns();
  Counts out{{rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}, exposure_s, 0, 0};
  std::atomic<std::size_t> saturated{0}, rejected{0};
  for_row_ranges(rows, [&](int first_row, int last_row) {
    RowReducer<double>::Scratch scratch;
    for (int row = first_row; row < last_row; ++row) {
      const CountsRow<double> to{out.rate_dn_per_s.row(row).data(), out.frame_floor.row(row).data(),
                                 out.shot.row(row).data(), out.dark_floor.row(row).data(), out.mask.row(row).data()};
      rejected += reducer.columns(row, 0, out.mask.columns(), to, scratch).rejected;
      std::size_t saturated_here = 0;
      for (const Mask m : std::as_const(out.mask).row(row)) saturated_here += (m & kSaturated) != 0;
      saturated += saturated_here;
    }
  });
  mask_bloom(out.mask);
  out.saturated_pixels = saturated;
  out.rejected_values = rejected;
  return out;
}

}  // namespace scatmap
