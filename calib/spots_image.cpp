#include "calib/spots_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/counts/reduce.h"

namespace scatmap::calib {
namespace {

double median_of(std::vector<double>& v) {
  if (v.empty()) return std::nan("");
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

// Strides that share no factor with usual widths, so that a sample is no column.
constexpr std::size_t kSample = 100003;

template <class Values>
double median_level(const Values& values) {
  std::vector<double> sample;
  const std::size_t stride = std::max<std::size_t>(1, values.size() / kSample);
  for (std::size_t i = 0; i < values.size(); i += stride) {
    if (std::isfinite(values[i])) sample.push_back(static_cast<double>(values[i]));
  }
  return median_of(sample);
}

// Standard deviation of a pixel from the differences of neighbours: blind to slow changes of the background.
double neighbour_scatter(const RawCounts& dn) {
  std::vector<double> differences;
  const std::size_t stride = std::max<std::size_t>(1, dn.size() / kSample);
  for (std::size_t i = 0; i + 1 < dn.size(); i += stride) {
    const double d = std::abs(static_cast<double>(dn[i + 1]) - static_cast<double>(dn[i]));
    if (std::isfinite(d)) differences.push_back(d);
  }
  constexpr double kNormalPerMad = 1.4826;
  return differences.empty() ? 0 : kNormalPerMad * median_of(differences) / std::sqrt(2.0);
}

MasterDark background_as_dark(const Frame& frame, const SensorModel& sensor) {
  MasterDark dark =
      stated_dark(median_level(frame.dn), 0, frame.dn.rows(), frame.dn.columns(), frame.quantum_dn, sensor);
  const double scatter = neighbour_scatter(frame.dn);
  const auto variance = static_cast<float>(std::max(dark.pooled_variance_dn2, scatter * scatter));
  std::fill(dark.single_variance_dn2.begin(), dark.single_variance_dn2.end(), variance);
  return dark;
}

void check_sensor(const SensorModel& sensor) {
  const auto positive = [](double value, const char* key) {
    if (value > 0) return;
    throw Error({std::string("sensor.") + key, "must be positive", number_text(value), {}});
  };
  positive(sensor.gain_e_per_dn, "gain_e_per_dn");
  positive(sensor.saturation_dn, "saturation_dn");
}

constexpr Mask kFilled = kHot | kBad | kNoData;

struct Neighbours {
  double median = 0;  // of up to eight
  // Of the four that share an edge. The lowest of three or more is left out: beside a dead pixel the light of a spot
  // would pass for a hot pixel.
  double cross_mean = 0;
  int cross_count = 0;
};

Neighbours neighbours_of(const SpotImage& image, int row, int column) {
  std::array<double, 8> all{};
  std::size_t count = 0;
  Neighbours out;
  double sum = 0, lowest = HUGE_VAL;
  for (int dr = -1; dr <= 1; ++dr) {
    for (int dc = -1; dc <= 1; ++dc) {
      const int r = row + dr, c = column + dc;
      if ((dr == 0 && dc == 0) || r < 0 || c < 0 || r >= image.net_e.rows() || c >= image.net_e.columns()) continue;
      if ((image.mask(r, c) & kFilled) != 0) continue;
      all[count++] = image.net_e(r, c);
      if (dr != 0 && dc != 0) continue;
      sum += image.net_e(r, c);
      lowest = std::min(lowest, image.net_e(r, c));
      ++out.cross_count;
    }
  }
  if (count == 0) return out;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(count / 2);
  const auto end = all.begin() + static_cast<std::ptrdiff_t>(count);
  std::nth_element(all.begin(), middle, end);
  out.median = count % 2 == 1 ? *middle : 0.5 * (*middle + *std::max_element(all.begin(), middle));
  if (out.cross_count >= 3) {
    sum -= lowest;
    --out.cross_count;
  }
  if (out.cross_count > 0) out.cross_mean = sum / out.cross_count;
  return out;
}

bool is_isolated(const SpotImage& image, int row, int column) {
  const double value = image.net_e(row, column), floor = image.floor_e2(row, column);
  if (!(value * value > kHotPixelSigmas * kHotPixelSigmas * floor) || value < 0) return false;
  const Neighbours n = neighbours_of(image, row, column);
  if (n.cross_count < 2) return false;
  const double excess = value - n.median;
  const double noise2 = floor + std::max(0.0, n.median);
  if (!(excess > 0 && excess * excess > kHotPixelSigmas * kHotPixelSigmas * noise2)) return false;
  // Light of a spot that narrow would show in the neighbours, with three sigmas to spare.
  const double missing = kHotNeighbourShare * excess - (n.cross_mean - n.median);
  return missing > 3 * std::sqrt(noise2 / n.cross_count);
}

}  // namespace

SpotImage spot_image(const Frame& frame, const std::optional<MasterDark>& dark, const SensorModel& sensor) {
  check_sensor(sensor);
  const double exposure_s = std::max(frame.header.exposure_s.value_or(1), 1e-9);
  Frame as_is{frame.dn, frame.quantum_dn, frame.file, {}};  // its exposure time cancels here
  const Counts counts = reduce({&as_is, 1}, dark ? *dark : background_as_dark(frame, sensor), sensor, {}, exposure_s);
  const double e_per_rate = exposure_s * sensor.gain_e_per_dn;
  SpotImage out{{frame.dn.rows(), frame.dn.columns()}, {frame.dn.rows(), frame.dn.columns()}, counts.mask, 0};
  for (std::size_t i = 0; i < out.net_e.size(); ++i) {
    out.net_e[i] = counts.rate_dn_per_s[i] * e_per_rate;
    out.floor_e2[i] = (static_cast<double>(counts.frame_floor[i]) + static_cast<double>(counts.dark_floor[i])) *
                      e_per_rate * e_per_rate;
    if (std::isfinite(out.net_e[i]) && std::isfinite(out.floor_e2[i])) continue;
    out.mask[i] |= kNoData;
    out.floor_e2[i] = sensor.read_noise_e * sensor.read_noise_e + sensor.gain_e_per_dn * sensor.gain_e_per_dn;
  }
  out.background_e = median_level(out.net_e);
  if (!std::isfinite(out.background_e)) throw Error({frame.file.string(), "has no finite pixel", {}, {}});
  return out;
}

SpotImage binned(const SpotImage& image, int factor) {
  const int rows = image.net_e.rows() / factor, columns = image.net_e.columns() / factor;
  SpotImage out{
      {rows, columns, 0.0}, {rows, columns, 0.0}, {rows, columns, Mask{0}}, image.background_e * factor * factor};
  Grid<int> filled(rows, columns, 0);
  for (int r = 0; r < rows * factor; ++r) {
    for (int c = 0; c < columns * factor; ++c) {
      const Mask mask = image.mask(r, c);
      out.net_e(r / factor, c / factor) += image.net_e(r, c);
      out.floor_e2(r / factor, c / factor) += image.floor_e2(r, c);
      out.mask(r / factor, c / factor) |= static_cast<Mask>(mask & (kSaturated | kBloom));
      filled(r / factor, c / factor) += (mask & kFilled) != 0 ? 1 : 0;
    }
  }
  for (std::size_t i = 0; i < filled.size(); ++i) {
    if (10 * filled[i] > factor * factor) out.mask[i] |= kNoData;
  }
  return out;
}

std::size_t mark_hot_pixels(SpotImage& image) {
  std::vector<std::pair<int, int>> found;
  for (int r = 0; r < image.net_e.rows(); ++r) {
    for (int c = 0; c < image.net_e.columns(); ++c) {
      if ((image.mask(r, c) & kFilled) != 0) continue;
      if (is_isolated(image, r, c)) found.emplace_back(r, c);
    }
  }
  for (const auto& [r, c] : found) image.mask(r, c) |= kHot;
  return found.size();
}

void fill_hot_pixels(SpotImage& image) {
  for (int r = 0; r < image.net_e.rows(); ++r) {
    for (int c = 0; c < image.net_e.columns(); ++c) {
      if ((image.mask(r, c) & kFilled) == 0) continue;
      const Neighbours n = neighbours_of(image, r, c);
      image.net_e(r, c) = n.cross_count > 0 ? n.median : image.background_e;
    }
  }
}

}  // namespace scatmap::calib
