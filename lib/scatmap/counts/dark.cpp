#include "scatmap/counts/dark.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/base/parallel_rows.h"

namespace scatmap {
namespace {

double median_in_place(std::vector<double>& v) {
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  if (v.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(v.begin(), middle));
}

// Median over at most ~1e5 pixels spread over the frame.
double typical_level(const Grid<float>& level) {
  const std::size_t stride = std::max<std::size_t>(1, level.size() / 100003);
  std::vector<double> sample;
  for (std::size_t i = 0; i < level.size(); i += stride) {
    if (std::isfinite(level[i])) sample.push_back(level[i]);
  }
  return sample.empty() ? std::numeric_limits<double>::quiet_NaN() : median_in_place(sample);
}

double noise_floor_dn2(const SensorModel& sensor, double quantum_dn) {
  return sensor.read_noise_dn() * sensor.read_noise_dn() + quantum_dn * quantum_dn / 12;
}

struct ClippedMean {
  double mean;
  double sum_of_squares;  // about the mean
  int count;
};

// Outliers are judged against the noise model, never against the scatter of a few values.
ClippedMean clipped_mean(std::vector<double>& values, double floor_dn2, const SensorModel& sensor) {
  double centre = 0, limit = std::numeric_limits<double>::infinity();
  if (values.size() >= 3) {
    centre = median_in_place(values);
    const double excess = std::max(0.0, centre - sensor.bias_dn);
    limit = kDarkOutlierSigmas * std::sqrt(floor_dn2 + excess / sensor.gain_e_per_dn);
  }
  double sum = 0;
  int count = 0;
  for (const double v : values) {
    if (std::abs(v - centre) <= limit) {
      sum += v;
      ++count;
    }
  }
  ClippedMean out{sum / count, 0, count};
  for (const double v : values) {
    if (std::abs(v - centre) <= limit) out.sum_of_squares += (v - out.mean) * (v - out.mean);
  }
  return out;
}

// Mean sample variance of pixels whose level is ordinary.
double pooled_variance(const MasterDark& dark, const Grid<float>& sample_variance, double typical, double spread) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < sample_variance.size(); ++i) {
    if (std::abs(dark.level_dn[i] - typical) <= kHotSigmas * spread && std::isfinite(sample_variance[i])) {
      sum += sample_variance[i];
      ++count;
    }
  }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

// Two outliers among the darks of one pixel are no cosmic hits: it flickers.
void finish(MasterDark& dark, const Grid<float>& sample_variance, const Grid<float>& count, std::size_t darks,
            double typical, const SensorModel& sensor) {
  const double hot_above = typical + kHotSigmas * std::sqrt(dark.pooled_variance_dn2);
  for_each_row(dark.level_dn.rows(), [&](int row) {
    for (int c = 0; c < dark.level_dn.columns(); ++c) {
      const double level = dark.level_dn(row, c), n = count(row, c);
      // Only where the level stands out of its own noise: a variance that followed the dark's fluctuation would
      // correlate with the net count (dark high, count low, weight low) and bias every weighted sum of faint pixels
      // upwards.
      const double excess = level - typical;
      const bool stands_out = std::abs(excess) > kExtraDarkSigmas * std::sqrt(dark.pooled_variance_dn2 / n);
      const double extra_shot = stands_out ? excess / sensor.gain_e_per_dn : 0;
      const double variance = std::max(0.5 * dark.pooled_variance_dn2, dark.pooled_variance_dn2 + extra_shot);
      dark.single_variance_dn2(row, c) = static_cast<float>(variance);
      dark.level_variance_dn2(row, c) = static_cast<float>(variance / n);
      const bool unstable = darks >= 4 && (n + 2 <= static_cast<double>(darks) ||
                                           sample_variance(row, c) > kUnstableVarianceRatio * variance);
      dark.mask(row, c) = level <= hot_above && !unstable ? Mask{0} : kHot;  // NaN is hot
    }
  });
}

}  // namespace

void require_same_shape(const Frame& a, const Frame& b) {
  if (a.dn.same_shape(b.dn)) return;
  const auto shape = [](const Frame& f) {
    return std::to_string(f.dn.columns()) + " x " + std::to_string(f.dn.rows());
  };
  throw Error({b.file.string(), "has the wrong size", shape(b), shape(a) + " as " + a.file.string()});
}

MasterDark combine_darks(std::span<const Frame> darks, const SensorModel& sensor) {
  if (darks.empty()) throw Error({"darks", "no dark frame", {}, {}});
  for (const Frame& d : darks) require_same_shape(darks.front(), d);
  const int rows = darks.front().dn.rows(), columns = darks.front().dn.columns();
  MasterDark out{{rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}};
  Grid<float> sample_variance(rows, columns), count(rows, columns);
  const double floor = noise_floor_dn2(sensor, darks.front().quantum_dn);
  for_each_row(rows, [&](int row) {
    std::vector<double> values(darks.size());
    for (int c = 0; c < columns; ++c) {
      for (std::size_t k = 0; k < darks.size(); ++k) values[k] = sensor.linearised(darks[k].dn(row, c));
      const ClippedMean m = clipped_mean(values, floor, sensor);
      out.level_dn(row, c) = static_cast<float>(m.mean);
      count(row, c) = static_cast<float>(m.count);
      sample_variance(row, c) =
          m.count > 1 ? static_cast<float>(m.sum_of_squares / (m.count - 1)) : std::numeric_limits<float>::quiet_NaN();
    }
  });
  const double typical = typical_level(out.level_dn);
  const double dark_shot = sensor.bias_dn > 0 ? std::max(0.0, typical - sensor.bias_dn) / sensor.gain_e_per_dn : 0;
  const double spread = std::sqrt(floor + dark_shot);
  constexpr std::size_t kEnough = 1000;  // pooled from at least this many differences, else the stated read noise
  const double pooled = pooled_variance(out, sample_variance, typical, spread);
  out.pooled_from_frames = pooled > 0 && (darks.size() - 1) * out.level_dn.size() >= kEnough;
  out.pooled_variance_dn2 = out.pooled_from_frames ? pooled : floor + dark_shot;
  finish(out, sample_variance, count, darks.size(), typical, sensor);
  return out;
}

MasterDark stated_dark(double level_dn, double u_level_dn, int rows, int columns, double quantum_dn,
                       const SensorModel& sensor) {
  const double floor = noise_floor_dn2(sensor, quantum_dn);
  MasterDark out{{rows, columns, static_cast<float>(sensor.linearised(level_dn))},
                 {rows, columns, static_cast<float>(floor)},
                 {rows, columns, static_cast<float>(u_level_dn * u_level_dn)},
                 {rows, columns, Mask{0}}};
  out.pooled_variance_dn2 = floor;
  return out;
}

}  // namespace scatmap
