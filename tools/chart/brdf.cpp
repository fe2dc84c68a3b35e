#include "tools/chart/brdf.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include "scatmap/base/parallel.h"
#include "scatmap/brdf/merge.h"
#include "scatmap/brdf/pose_uncertainty.h"
#include "tools/chart/brdf_scene.h"
#include "tools/chart/error_sample.h"
#include "tools/chart/scene.h"
#include "tools/chart/timing.h"

namespace scatmap::tools {
namespace {

constexpr int kErrorStep = 37;  // every so many pixels are compared with the long double quotient

std::string size_text(const Instrument& in) { return std::to_string(in.columns) + " x " + std::to_string(in.rows); }

// The reference method: one step after the other over whole images.
FusedPlanes<double> exact_chain(const BrdfScene& s, bool with_pose) {
  const Counts counts = reduce(s.frames, s.dark, s.sensor, s.response, s.exposure_s);
  const std::vector<ScaledCounts> one{{&counts, s.factor, 0}};
  const Merged merged = merge(one);
  const AngleMap angles = angle_map(s.instrument, s.pose);
  const int rows = counts.mask.rows(), columns = counts.mask.columns();
  FusedPlanes<double> out{{rows, columns}, {rows, columns}, {}, {rows, columns}, {rows, columns}, {rows, columns}};
  for_each_row(rows, [&](int r) {
    for (int c = 0; c < columns; ++c) {
      const double projected = angles.solid_angle_sr(r, c) * std::cos(angles.theta_s_rad(r, c));
      const auto mask = static_cast<Mask>(merged.mask(r, c) | angles.mask(r, c));
      const double keep = mask == 0 ? 1 : std::numeric_limits<double>::quiet_NaN();
      out.mask(r, c) = mask;
      out.brdf_per_sr(r, c) = keep * merged.value(r, c) / projected;
      out.u_random_per_sr(r, c) = static_cast<float>(keep * std::sqrt(merged.variance(r, c)) / projected);
      out.expected_per_sr(r, c) = keep * merged.expected(r, c) / projected;
    }
  });
  if (!with_pose) return out;
  out.u_pose_per_sr = *pose_uncertainty(s.instrument, s.pose, out.expected_per_sr);
  for (std::size_t i = 0; i < out.mask.size(); ++i)
    out.u_total_per_sr[i] = std::hypot(out.u_random_per_sr[i], out.u_pose_per_sr[i]);
  return out;
}

// As array packages compute it: each step makes a new image of doubles; the noise is that of the pixel's own count.
FusedPlanes<double> naive_passes(const BrdfScene& s, const Grid<float>& dn) {
  const int rows = s.dark.mask.rows(), columns = s.dark.mask.columns();
  const auto image = [&](auto&& value) {
    Grid<double> out(rows, columns);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = value(i);
    return out;
  };
  const double read2 = s.sensor.read_noise_dn() * s.sensor.read_noise_dn();
  const Grid<double> deviation = image([&](std::size_t i) {
    return std::sqrt(std::max(0.0, dn[i] - s.sensor.bias_dn) / s.sensor.gain_e_per_dn + read2);
  });
  const Grid<double> net = image([&](std::size_t i) { return static_cast<double>(dn[i]) - s.dark.level_dn[i]; });
  const Grid<double> net_deviation =
      image([&](std::size_t i) { return std::sqrt(deviation[i] * deviation[i] + s.dark.level_variance_dn2[i]); });
  const Grid<double> rate = image([&](std::size_t i) { return net[i] / s.exposure_s; });
  const Grid<double> u_rate = image([&](std::size_t i) { return net_deviation[i] / s.exposure_s; });
  const AngleMap angles = angle_map(s.instrument, s.pose);
  const Grid<double> projected =
      image([&](std::size_t i) { return angles.solid_angle_sr[i] * std::cos(angles.theta_s_rad[i]); });
  FusedPlanes<double> out{image([&](std::size_t i) { return rate[i] * s.factor / projected[i]; }),
                          {rows, columns},
                          {},
                          {},
                          {rows, columns},
                          {}};
  for (std::size_t i = 0; i < out.mask.size(); ++i) {
    out.u_random_per_sr[i] = static_cast<float>(u_rate[i] * s.factor / projected[i]);
    out.mask[i] = dn[i] >= s.sensor.saturation_dn ? kSaturated : s.dark.mask[i];
  }
  return out;
}

// Against counts/(Ω cos theta_s) with the divisor in long double.
template <class T>
ErrorSample errors_of(const FusedPlanes<T>& planes, const BrdfScene& s) {
  const SampleView view = sample_view(s.instrument, s.pose);
  const Counts counts = reduce(s.frames, s.dark, s.sensor, s.response, s.exposure_s);
  ErrorSample out;
  const auto columns = static_cast<std::size_t>(counts.mask.columns());
  for (std::size_t i = 0; i < counts.mask.size(); i += kErrorStep) {
    if (counts.mask[i] != 0 || counts.rate_dn_per_s[i] == 0) continue;  // of 0 there is no relative error
    const int row = static_cast<int>(i / columns), column = static_cast<int>(i % columns);
    const Vector3<long double> d = view.pixel(column, row).cast<long double>();
    const long double r2 = d.squaredNorm(), facing = view.detector_normal.cast<long double>().dot(d);
    const long double truth = static_cast<long double>(counts.rate_dn_per_s[i]) * s.factor * r2 * r2 /
                              (static_cast<long double>(view.pixel_area_m2) * facing * d.z());
    // The pass's rounding is relative to the count and its noise: near zero counts a ratio alone would say nothing.
    const long double scale = std::abs(truth) + static_cast<long double>(planes.u_random_per_sr[i]);
    out.add(static_cast<double>((planes.brdf_per_sr[i] - truth) / scale), column, row);
  }
  return out;
}

double largest_ratio_error(const Grid<float>& a, const Grid<float>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
    if (b[i] > 0) largest = std::max(largest, std::abs(static_cast<double>(a[i]) / b[i] - 1));
  }
  return largest;
}

template <class T>
std::string uncertainty_note(const FusedPlanes<T>& planes, const FusedPlanes<double>& exact) {
  char text[120];
  if (planes.u_pose_per_sr.empty()) {
    std::snprintf(text, sizeof text, "without u_pose; u_random within %.1e of exact",
                  largest_ratio_error(planes.u_random_per_sr, exact.u_random_per_sr));
  } else {
    std::snprintf(text, sizeof text, "17 parameters; u_random within %.1e, u_pose within %.1e of exact",
                  largest_ratio_error(planes.u_random_per_sr, exact.u_random_per_sr),
                  largest_ratio_error(planes.u_pose_per_sr, exact.u_pose_per_sr));
  }
  return text;
}

class Rows {
 public:
  Rows(const BrdfScene& scene, double seconds, Chart& chart)
      : scene_(scene), seconds_(seconds), chart_(chart), exact_(exact_chain(scene, true)) {}

  // `work` returns the planes by reference or value.
  template <class Work>
  void add(const char* method, int threads, Work&& work, std::optional<double> bound = {}, bool rival = false) {
    ChartRow row;
    row.method = method;
    row.size = size_text(scene_.instrument);
    row.threads = threads;
    row.rival = rival;
    row.bound = bound;
    row.time = with_threads(
        threads, [&] { return time_per_item(scene_.dark.mask.size(), seconds_, [&] { keep(work().mask.data()); }); });
    const auto& planes = work();
    const ErrorSample errors = errors_of(planes, scene_);
    row.largest_error = errors.largest();
    row.p99_error = errors.percentile(99);
    row.worst_at = errors.worst_at();
    row.note = uncertainty_note(planes, exact_);
    chart_.rows.push_back(std::move(row));
  }

 private:
  const BrdfScene& scene_;
  double seconds_;
  Chart& chart_;
  FusedPlanes<double> exact_;
};

void add_rows(const BrdfScene& s, double seconds, Chart& chart) {
  const SampleView view = sample_view(s.instrument, s.pose);
  const PoseTiles tiles(view, calibration_changes(s.instrument, s.pose), s.instrument.rows, s.instrument.columns);
  Rows rows(s, seconds, chart);
  for (const int threads : {1, 2}) {
    rows.add("exact", threads, [&] { return exact_chain(s, true); });
    for (const PoseTiles* pose : {&tiles, static_cast<const PoseTiles*>(nullptr)}) {
      FusedPlanes<float> planes;  // filled again each time: no fresh memory is touched
      rows.add(
          pose != nullptr ? "fused" : "fused without pose", threads,
          [&]() -> const FusedPlanes<float>& {
            fused_map(s.fused_frames(), {view, nullptr, pose}, {}, planes);
            return planes;
          },
          kFusedBrdfMaxError);
    }
  }
  RawCounts counts = s.frames.front().dn;
  const Grid<float>& dn = counts.floats();
  rows.add(
      "naive passes", 1, [&] { return naive_passes(s, dn); }, {}, true);
}

}  // namespace

std::vector<Chart> chart_brdf(const ChartSettings& s) {
  Chart chart{"brdf",  "Counts to BRDF: one raw frame and a master dark in memory to map, uncertainties and mask",
              "pixel", "error of the BRDF over |f| + u_random",
              "",      "counts over a long double solid angle",
              {},      {},
              {}};
  for (const auto& [columns, rows] : {std::pair{1024, 1024}, std::pair{s.instrument.columns, s.instrument.rows}})
    add_rows(brdf_scene(resized(s.instrument, columns, rows), s.pose, 1), s.seconds_per_method, chart);
  return {chart};
}

}  // namespace scatmap::tools
