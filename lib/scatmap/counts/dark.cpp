#include "scatmap/counts/dark.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/parallel.h"
#include "scatmap/counts/row_kernels.h"

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

// Mean sample variance of pixels whose level is ordinary; rows summed apart, so that threads do not change it.
double pooled_variance(const MasterDark& dark, const Grid<float>& sample_variance, double typical, double spread) {
  const auto rows = static_cast<std::size_t>(dark.level_dn.rows());
  std::vector<PooledRow> of_row(rows);
  for_each_row(dark.level_dn.rows(), [&](int row) {
    of_row[static_cast<std::size_t>(row)] = pooled_row(dark.level_dn.row(row).data(), sample_variance.row(row).data(),
                                                       dark.level_dn.columns(), typical, kHotSigmas * spread);
  });
  double sum = 0, count = 0;
  for (const PooledRow& row : of_row) {
    sum += row.sum;
    count += row.count;
  }
  return count > 0 ? sum / count : 0;
}

// Two outliers among the darks of one pixel are no cosmic hits: it flickers. Its own dark charge counts only where the
// level stands out of its own noise: a variance that followed the dark's fluctuation would correlate with the net count
// (dark high, count low, weight low) and bias every weighted sum of faint pixels upwards.
void finish(MasterDark& dark, const Grid<float>& sample_variance, const Grid<float>& count, std::size_t darks,
            double typical, const SensorModel& sensor) {
  const FinishConstants k{static_cast<double>(darks),
                          dark.pooled_variance_dn2,
                          typical,
                          typical + kHotSigmas * std::sqrt(dark.pooled_variance_dn2),
                          sensor.gain_e_per_dn,
                          kExtraDarkSigmas,
                          kUnstableVarianceRatio};
  for_each_row(dark.level_dn.rows(), [&](int row) {
    finish_dark_row(dark.level_dn.row(row).data(), count.row(row).data(), sample_variance.row(row).data(),
                    dark.level_dn.columns(), k, dark.single_variance_dn2.row(row).data(),
                    dark.level_variance_dn2.row(row).data(), dark.mask.row(row).data());
  });
}

// One pixel whose values need judging, or that the vector loop passed on.
void judge(std::span<const Frame> darks, int row, int column, double floor, const SensorModel& sensor,
           std::vector<double>& values, float& level, float& sample_variance, float& count) {
  for (std::size_t k = 0; k < darks.size(); ++k) values[k] = sensor.linearised(darks[k].dn(row, column));
  const ClippedMean m = clipped_mean(values, floor, sensor);
  level = static_cast<float>(m.mean);
  count = static_cast<float>(m.count);
  sample_variance =
      m.count > 1 ? static_cast<float>(m.sum_of_squares / (m.count - 1)) : std::numeric_limits<float>::quiet_NaN();
}

// Mean, scatter and number of the darks kept, row by row.
void combine_rows(std::span<const Frame> darks, double floor, const SensorModel& sensor, Grid<float>& level,
                  Grid<float>& sample_variance, Grid<float>& count) {
  const DarkConstants k{static_cast<double>(darks.size()), floor, sensor.bias_dn, sensor.gain_e_per_dn,
                        kDarkOutlierSigmas * kDarkOutlierSigmas};
  for_row_ranges(level.rows(), [&](int first_row, int last_row) {
    std::vector<double> values(darks.size());
    std::vector<const float*> raw(darks.size());
    std::vector<float, HugePageAllocator<float>> buffer(darks.size() * kStrip);
    const auto sums = std::make_unique_for_overwrite<StripSums<double>>();
    for (int row = first_row; row < last_row; ++row) {
      std::fill_n(count.row(row).data(), level.columns(), static_cast<float>(darks.size()));
      for (int c = 0; c < level.columns(); c += kStrip) {
        const int pixels = std::min(kStrip, level.columns() - c);
        for (std::size_t i = 0; i < darks.size(); ++i)
          raw[i] = darks[i].dn.part(row, c, pixels, buffer.data() + i * kStrip);
        sum_darks(raw, pixels, sensor, *sums);
        if (!dark_strip(*sums, k, pixels, &level(row, c), &sample_variance(row, c))) continue;
        for (int i = 0; i < pixels; ++i) {
          if (sums->doubtful[i] != 0)
            judge(darks, row, c + i, floor, sensor, values, level(row, c + i), sample_variance(row, c + i),
                  count(row, c + i));
        }
      }
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

namespace {

void require_type(const Frame& frame, std::initializer_list<const char*> others, const char* what_not,
                  const char* expected) {
  if (!frame.header.image_type) return;
  std::string type = *frame.header.image_type;
  std::transform(type.begin(), type.end(), type.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* other : others) {
    if (type.find(other) == std::string::npos) continue;
    throw Error({frame.file.string() + ": IMAGETYP", std::string("says that it is no ") + what_not,
                 *frame.header.image_type, expected});
  }
}

}  // namespace

void require_dark(const Frame& frame) { require_type(frame, {"light", "flat", "object"}, "dark", "a dark frame"); }

void require_light(const Frame& frame) {
  require_type(frame, {"dark", "bias", "flat"}, "light frame", "a frame of the beam or the sample");
}

void require_flat(const Frame& frame) {
  require_type(frame, {"light", "object", "dark", "bias"}, "flat field", "a flat frame");
}

MasterDark combine_darks(std::span<const Frame> darks, const SensorModel& sensor) {
  if (darks.empty()) throw Error({"darks", "no dark frame", {}, {}});
  for (const Frame& d : darks) require_same_shape(darks.front(), d);
  const int rows = darks.front().dn.rows(), columns = darks.front().dn.columns();
  MasterDark out{{rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}};
  Grid<float> sample_variance(rows, columns), count(rows, columns);
  const double floor = noise_floor_dn2(sensor, darks.front().quantum_dn);
  combine_rows(darks, floor, sensor, out.level_dn, sample_variance, count);
  const double typical = typical_level(out.level_dn);
  if (!(typical < sensor.saturation_dn)) {
    throw Error({darks.front().file.string(), "is no dark: half of its pixels and more are saturated",
                 number_text(typical) + " DN", "less than saturation_dn = " + number_text(sensor.saturation_dn)});
  }
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
