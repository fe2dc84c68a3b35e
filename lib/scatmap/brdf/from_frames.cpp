#include "scatmap/brdf/from_frames.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "scatmap/base/error.h"
#include "scatmap/base/parallel_rows.h"
#include "scatmap/brdf/frame_source.h"
#include "scatmap/brdf/merge.h"
#include "scatmap/brdf/pose_uncertainty.h"

namespace scatmap {
namespace {

struct Reductions {
  std::vector<FrameSource::Reduced> samples;
  std::vector<double> factors;  // map units per DN/s
};

// A cause with one sensitivity per exposure.
struct SharedCause {
  ScaleCause cause;
  std::vector<double> sensitivity;
};

// Exposure times of different exposures are different shutter errors; every other name is one object.
std::vector<SharedCause> causes_by_identity(const std::vector<ScaleBudget>& budgets) {
  std::vector<SharedCause> out;
  for (std::size_t e = 0; e < budgets.size(); ++e) {
    for (ScaleCause cause : budgets[e].causes) {
      if (budgets.size() > 1 && cause.name == "exposure time of the sample") cause.name = "exposure time of exposure " + std::to_string(e + 1);
      auto found = std::find_if(out.begin(), out.end(), [&](const SharedCause& s) { return s.cause.name == cause.name; });
      if (found == out.end()) {
        out.push_back({cause, std::vector<double>(budgets.size(), 0)});
        found = out.end() - 1;
      }
      found->sensitivity[e] = cause.sensitivity;
    }
  }
  return out;
}

std::string extension_name(const std::string& cause) {
  std::string name = "U_";
  for (const char c : cause) name += std::isalnum(static_cast<unsigned char>(c)) ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : '_';
  return name;
}

double share_of(const Merged& merged, std::size_t exposure, std::size_t pixel) {
  return merged.share.empty() ? 1.0 : static_cast<double>(merged.share[exposure][pixel]);
}

// Causes that act alike on every exposure are scale; the others move each pixel by its exposures' shares.
void split_causes(const std::vector<ScaleBudget>& budgets, const Merged& merged, const Grid<double>& expected_per_sr, BrdfMap& map) {
  for (const SharedCause& s : causes_by_identity(budgets)) {
    const bool common = std::all_of(s.sensitivity.begin(), s.sensitivity.end(), [&](double v) { return v == s.sensitivity.front(); });
    if (common) {
      map.scale.causes.push_back(s.cause);
      continue;
    }
    ScaleCause unit = s.cause;
    unit.sensitivity = 1;
    StructuredCause out{extension_name(s.cause.name), s.cause.name + ", weighted by exposure", Grid<float>(merged.mask.rows(), merged.mask.columns())};
    for (std::size_t i = 0; i < expected_per_sr.size(); ++i) {
      double sensitivity = 0;
      for (std::size_t e = 0; e < budgets.size(); ++e) sensitivity += share_of(merged, e, i) * s.sensitivity[e];
      out.sensitivity_per_sr[i] = static_cast<float>(expected_per_sr[i] * sensitivity * unit.standard());
    }
    map.structured.push_back(std::move(out));
  }
}

// One unknown curvature: relative deviation grows with the level and reaches nonlinearity_percent at saturation. The
// signature was measured through the same pixels' curve at its own level.
void add_nonlinearity(const Measurement& m, const Reductions& r, const Signature& signature, const Merged& merged,
                      const Grid<double>& expected_per_sr, BrdfMap& map) {
  const Sensor& s = m.instrument.sensor;
  if (s.nonlinearity_percent <= 0) return;
  const double u = s.nonlinearity_percent / 100 / std::numbers::sqrt3, range = *s.saturation_dn - s.bias_dn;
  const double signature_level = signature.effective_rate * m.signature.exposure_s / range;
  StructuredCause out{"U_NONLIN", "pixel non-linearity", Grid<float>(merged.mask.rows(), merged.mask.columns())};
  for (std::size_t i = 0; i < expected_per_sr.size(); ++i) {
    double level = 0;
    for (std::size_t e = 0; e < r.samples.size(); ++e) {
      const double share = share_of(merged, e, i);
      if (share > 0) level += share * std::max(0.0, merged.expected[i]) / r.factors[e] * r.samples[e].counts.exposure_s / range;
    }
    out.sensitivity_per_sr[i] = static_cast<float>(expected_per_sr[i] * u * (level - signature_level));
  }
  map.structured.push_back(std::move(out));
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
      map.u_random_per_sr(row, c) = static_cast<float>(mask == 0 ? std::sqrt(merged.variance(row, c)) / projected : kNaN);
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

Reductions reduce_all(const Measurement& m, FrameSource& source, const Signature& signature, const Progress& progress, BrdfMap& map) {
  Reductions out;
  for (std::size_t e = 0; e < m.exposures.size(); ++e) {
    if (progress) progress("exposure " + std::to_string(e + 1), static_cast<double>(e + 1) / static_cast<double>(m.exposures.size() + 2));
    out.samples.push_back(source.reduce_exposure(m.exposures[e], "exposure " + std::to_string(e + 1)));
    out.factors.push_back(std::pow(10, stack_od(m, m.exposures[e]) - stack_od(m, m.signature)) / signature.rate_dn_per_s);
    map.exposures.push_back(out.samples.back().record);
    note_noise(out.samples.back(), source.sensor(), map);
  }
  return out;
}

Merged merge_all(const Reductions& r) {
  std::vector<ScaledCounts> scaled;
  for (std::size_t e = 0; e < r.samples.size(); ++e) scaled.push_back({&r.samples[e].counts, r.factors[e], r.samples[e].dark_group});
  return merge(scaled);
}

// Errors of rooms that know no files, with the file the user has to mend.
SampleView view_of(const Measurement& m) try {
  return sample_view(m.instrument, m.pose);
} catch (const Error& e) {
  throw with_context(m.file.string() + " with " + m.instrument_file.string(), e);
}

Signature signature_of(const Measurement& m, const Counts& counts) try {
  return measure_signature(counts, m.aperture.radius_px);
} catch (const Error& e) {
  throw with_context(m.file.string(), e);
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

BrdfResult brdf_from_frames(const Measurement& m, const Progress& progress) {
  BrdfResult out;
  BrdfMap& map = out.map;
  map.instrument = m.instrument;
  map.pose = m.pose;
  map.wavelength_m = m.wavelength_m;
  const SampleView view = view_of(m);
  FrameSource source(m);
  if (progress) progress("signature", 0);
  {
    const FrameSource::Reduced reduced = source.reduce_exposure(m.signature, "signature");
    out.signature = signature_of(m, reduced.counts);
    map.exposures.push_back(reduced.record);
    note_noise(reduced, source.sensor(), map);
  }
  const Reductions reductions = reduce_all(m, source, out.signature, progress, map);
  if (progress) progress("map", 0.9);
  const Merged merged = merge_all(reductions);
  map.angles = angle_map(view, m.instrument.rows, m.instrument.columns);
  const Grid<double> expected = apply_geometry(merged, map);

  require_some_good_pixel(m, map);
  const double u_signature = out.signature.u_rate_dn_per_s / out.signature.rate_dn_per_s;
  for (const Exposure& e : m.exposures) out.exposure_scale.push_back(exposure_scale(m, e, u_signature));
  split_causes(out.exposure_scale, merged, expected, map);
  add_nonlinearity(m, reductions, out.signature, merged, expected, map);
  if (auto u_pose = pose_uncertainty(m.instrument, m.pose, expected)) map.u_pose_per_sr = std::move(*u_pose);
  return out;
}

}  // namespace scatmap
