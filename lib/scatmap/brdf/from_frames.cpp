#include "scatmap/brdf/from_frames.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/parallel_rows.h"
#include "scatmap/brdf/frame_source.h"
#include "scatmap/brdf/merge.h"
#include "scatmap/brdf/pose_uncertainty.h"
#include "scatmap/brdf/split_causes.h"

namespace scatmap {
namespace {

constexpr double kVisibleSeam = 2e-3;  // a step between exposures that the user should hear of

struct Reductions {
  std::vector<FrameSource::Reduced> samples;
  std::vector<double> factors;  // map units per DN/s
};

double share_of(const Merged& merged, std::size_t exposure, std::size_t pixel) {
  return merged.share.empty() ? 1.0 : static_cast<double>(merged.share[exposure][pixel]);
}

double u_nonlinearity(const Measurement& m) {
  return m.instrument.sensor.nonlinearity_percent / 100 / std::numbers::sqrt3;
}

// Share of the sensor's linear range at which an exposure works, per map unit.
std::vector<double> levels_per_unit(const Measurement& m, const Reductions& r) {
  const Sensor& s = m.instrument.sensor;
  std::vector<double> out;
  for (std::size_t e = 0; e < r.samples.size(); ++e)
    out.push_back(r.samples[e].counts.exposure_s / r.factors[e] / (*s.saturation_dn - s.bias_dn));
  return out;
}

// One unknown curvature: relative deviation grows with the level and reaches nonlinearity_percent at saturation. The
// signature was measured through the same pixels' curve at its own level.
Grid<float> nonlinearity_change(const Measurement& m, const Reductions& r, const Signature& signature,
                                const Merged& merged) {
  const double u = u_nonlinearity(m);
  if (!(u > 0)) return {};
  const Sensor& s = m.instrument.sensor;
  const double signature_level = signature.effective_rate * m.signature.exposure_s / (*s.saturation_dn - s.bias_dn);
  const std::vector<double> per_unit = levels_per_unit(m, r);
  Grid<float> out(merged.mask.rows(), merged.mask.columns());
  for (std::size_t i = 0; i < out.size(); ++i) {
    double level = 0;
    for (std::size_t e = 0; e < r.samples.size(); ++e) {
      const double share = share_of(merged, e, i);
      if (share > 0) level += share * std::max(0.0, merged.expected[i]) * per_unit[e];
    }
    out[i] = static_cast<float>(u * (level - signature_level));
  }
  return out;
}

// Divides by Ω cos theta_s; returns the expected BRDF, for gradients and structured causes.
Grid<double> apply_geometry(const Merged& merged, BrdfMap& map) {
  const int rows = merged.mask.rows(), columns = merged.mask.columns();
  map.brdf_per_sr = Grid<double>(rows, columns);
  map.u_random_per_sr = Grid<float>(rows, columns);
  map.mask = Grid<Mask>(rows, columns);
  Grid<double> expected(rows, columns);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for_each_row(rows, [&](int row) {
    for (int c = 0; c < columns; ++c) {
      const double projected = map.angles.solid_angle_sr(row, c) * std::cos(map.angles.theta_s_rad(row, c));
      Mask mask = static_cast<Mask>(merged.mask(row, c) | map.angles.mask(row, c));
      const double f = merged.value(row, c) / projected;
      if (mask == 0 && !std::isfinite(f)) mask = kNoData;
      map.mask(row, c) = mask;
      map.brdf_per_sr(row, c) = mask == 0 ? f : kNaN;
      map.u_random_per_sr(row, c) =
          static_cast<float>(mask == 0 ? std::sqrt(merged.variance(row, c)) / projected : kNaN);
      expected(row, c) = mask == 0 ? merged.expected(row, c) / projected : kNaN;
    }
  });
  return expected;
}

void note_noise(const FrameSource::Reduced& reduced, const SensorModel& sensor, BrdfMap& map) {
  if (reduced.pooled_dark_noise_dn == 0) return;
  const double ratio = reduced.pooled_dark_noise_dn / sensor.read_noise_dn();
  if (ratio < 0.7) {
    map.notes.push_back("darks of " + reduced.record.role + " scatter by " + std::to_string(ratio) +
                        " of the stated read noise: check sensor.read_noise_e and gain_e_per_dn");
  }
}

Reductions reduce_all(const Measurement& m, FrameSource& source, const Signature& signature, const Progress& progress,
                      BrdfMap& map) {
  Reductions out;
  for (std::size_t e = 0; e < m.exposures.size(); ++e) {
    if (progress)
      progress("exposure " + std::to_string(e + 1),
               static_cast<double>(e + 1) / static_cast<double>(m.exposures.size() + 2));
    out.samples.push_back(source.reduce_exposure(m.exposures[e], "exposure " + std::to_string(e + 1)));
    out.factors.push_back(std::pow(10, stack_od(m, m.exposures[e]) - stack_od(m, m.signature)) /
                          signature.rate_dn_per_s);
    map.exposures.push_back(out.samples.back().record);
    note_noise(out.samples.back(), source.sensor(), map);
  }
  return out;
}

std::vector<ScaledCounts> scaled(const Reductions& r) {
  std::vector<ScaledCounts> out;
  for (std::size_t e = 0; e < r.samples.size(); ++e)
    out.push_back({&r.samples[e].counts, r.factors[e], r.samples[e].dark_group});
  return out;
}

std::string percent(double relative) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %%", 100 * relative);
  return text;
}

void note_overlap(const OverlapReport& o, BrdfMap& map) {
  for (std::size_t k = 0; k < o.causes.causes.size(); ++k) {
    const ScaleCause& c = o.causes.causes[k];
    const double shift = o.solution.shift[static_cast<Eigen::Index>(k)];
    // Three standard uncertainties: a filter known only together with others may seem off by their tolerance.
    const auto i = static_cast<Eigen::Index>(k);
    if (c.distribution != Distribution::kNormal &&
        std::abs(shift) > c.worst_case() + 3 * std::sqrt(o.solution.covariance(i, i))) {
      map.notes.push_back(c.name + " is " + number_text(shift) + " off its stated value, beyond its tolerance of " +
                          number_text(c.worst_case()));
    }
  }
  for (const OverlapPair& p : o.solution.pairs) {
    const std::string names = "exposures " + std::to_string(p.a + 1) + " and " + std::to_string(p.b + 1);
    if (!p.problem.empty()) {
      map.notes.push_back(names + " are inconsistent and their overlap was not used: " + p.problem);
    } else if (p.used && std::abs(p.ln_ratio) > kVisibleSeam + 3 * p.u) {
      map.notes.push_back(names + " leave a step of " + percent(p.ln_ratio));
    }
  }
}

// Measures the exposures' factors from their overlaps and applies them.
std::optional<OverlapReport> measure_overlap(const Measurement& m, const ExposureCauses& causes, Reductions& r,
                                             BrdfMap& map) {
  bool any = false;
  for (std::size_t k = 0; k < causes.causes.size(); ++k) any = any || !causes.is_common(k);
  if (r.samples.size() < 2 || !any) return std::nullopt;
  OverlapReport out{causes, solve_overlap(scaled(r), causes, levels_per_unit(m, r), u_nonlinearity(m))};
  for (std::size_t e = 0; e < r.factors.size(); ++e) r.factors[e] *= out.solution.factor(causes, e);
  note_overlap(out, map);
  return out;
}

// Before any frame is read.
void require_possible_pose(const Measurement& m) {
  try {
    sample_view(m.instrument, m.pose);
  } catch (const Error& e) {
    throw with_context(m.file.string(), e);
  }
}

AngleMap angles_of(const Measurement& m) {
  try {
    return angle_map(m.instrument, m.pose);
  } catch (const Error& e) {
    throw with_context(m.instrument_file.string(), e);
  }
}

void add_pose_uncertainty(const Measurement& m, const Grid<double>& expected, BrdfMap& map) {
  if (m.instrument.lens_cameramodel && m.instrument.calibration) {
    map.notes.push_back("pose uncertainty is left out: the calibration describes a flat detector, not one with a lens");
    return;
  }
  if (auto u_pose = pose_uncertainty(m.instrument, m.pose, expected)) map.u_pose_per_sr = std::move(*u_pose);
}

Signature signature_of(const Measurement& m, const Counts& counts) {
  try {
    return measure_signature(counts, m.aperture.radius_px);
  } catch (const Error& e) {
    throw with_context(m.file.string(), e);
  }
}

// A map without a single number is no result.
void require_some_good_pixel(const Measurement& m, const BrdfMap& map) {
  Mask every = static_cast<Mask>(~0u);
  for (const Mask mask : map.mask) {
    if (mask == 0) return;
    every &= mask;
  }
  std::string reason;
  for (const MaskFlag& flag : kMaskFlags) {
    if ((every & flag.bit) != 0) reason = std::string(": ") + flag.meaning;
  }
  throw Error({m.file.string(), "gives a map without a good pixel" + reason, {}, {}});
}

}  // namespace

BrdfResult brdf_from_frames(const Measurement& m, const Progress& progress, FilterValues filters) {
  BrdfResult out;
  BrdfMap& map = out.map;
  map.instrument = m.instrument;
  map.pose = m.pose;
  map.wavelength_m = m.wavelength_m;
  require_possible_pose(m);
  FrameSource source(m);
  if (progress) progress("signature", 0);
  {
    const FrameSource::Reduced reduced = source.reduce_exposure(m.signature, "signature");
    out.signature = signature_of(m, reduced.counts);
    map.exposures.push_back(reduced.record);
    note_noise(reduced, source.sensor(), map);
  }
  Reductions reductions = reduce_all(m, source, out.signature, progress, map);
  const double u_signature = out.signature.u_rate_dn_per_s / out.signature.rate_dn_per_s;
  for (const Exposure& e : m.exposures) out.exposure_scale.push_back(exposure_scale(m, e, u_signature));
  const ExposureCauses causes = causes_by_identity(out.exposure_scale);
  if (progress) progress("overlap", 0.8);
  if (filters == FilterValues::kByOverlap) out.overlap = measure_overlap(m, causes, reductions, map);
  if (progress) progress("map", 0.9);
  const Merged merged = merge(scaled(reductions));
  map.angles = angles_of(m);
  const Grid<double> expected = apply_geometry(merged, map);
  require_some_good_pixel(m, map);
  const Grid<float> nonlinearity = nonlinearity_change(m, reductions, out.signature, merged);
  split_causes(causes, out.overlap ? &out.overlap->solution : nullptr, {merged, expected, nonlinearity}, map);
  add_pose_uncertainty(m, expected, map);
  return out;
}

}  // namespace scatmap
