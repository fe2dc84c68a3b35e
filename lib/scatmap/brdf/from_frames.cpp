#include "scatmap/brdf/from_frames.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/parallel.h"
#include "scatmap/brdf/beam_window.h"
#include "scatmap/brdf/exposure_agreement.h"
#include "scatmap/brdf/frame_source.h"
#include "scatmap/brdf/fused.h"
#include "scatmap/brdf/map_notes.h"
#include "scatmap/brdf/merge.h"
#include "scatmap/brdf/pose_uncertainty.h"
#include "scatmap/brdf/split_causes.h"

namespace scatmap {
namespace {

struct Reductions {
  std::vector<FrameSource::Reduced> samples;
  std::vector<double> factors;  // map units per DN/s; before the signature is known: of the first signature exposure
};

// The signature's exposures, or, of a single one, only what it says.
struct Beam {
  Reductions exposures;
  std::optional<MergedSignature> measured;
};

double share_of(const Merged& merged, std::size_t exposure, std::size_t pixel) {
  return merged.share.empty() ? 1.0 : static_cast<double>(merged.share[exposure][pixel]);
}

double u_nonlinearity(const Measurement& m) {
  return m.instrument.sensor.nonlinearity_percent / 100 / std::numbers::sqrt3;
}

// Share of the sensor's linear range at which an exposure works, per map unit.
double level_per_unit(const Measurement& m, double exposure_s, double factor) {
  const Sensor& s = m.instrument.sensor;
  return exposure_s / factor / (*s.saturation_dn - s.bias_dn);
}

std::vector<double> levels_per_unit(const Measurement& m, const Reductions& r) {
  std::vector<double> out;
  for (std::size_t e = 0; e < r.samples.size(); ++e)
    out.push_back(level_per_unit(m, r.samples[e].counts.exposure_s, r.factors[e]));
  return out;
}

// One unknown curvature: relative deviation grows with the level and reaches nonlinearity_percent at saturation. The
// signature was measured through the same pixels' curve at its own level.
Grid<float> nonlinearity_change(const Measurement& m, const std::vector<double>& per_unit,
                                const MergedSignature& signature, const Merged& merged) {
  const double u = u_nonlinearity(m);
  if (!(u > 0)) return {};
  const Sensor& s = m.instrument.sensor;
  const double signature_level = signature.level_dn / (*s.saturation_dn - s.bias_dn);
  Grid<float> out(merged.expected.rows(), merged.expected.columns());
  for_each_row(out.rows(), [&](int row) {
    for (int c = 0; c < out.columns(); ++c) {
      const auto i = static_cast<std::size_t>(&out(row, c) - out.data());
      double level = 0;
      for (std::size_t e = 0; e < per_unit.size(); ++e) {
        const double share = share_of(merged, e, i);
        if (share > 0) level += share * std::max(0.0, merged.expected[i]) * per_unit[e];
      }
      out[i] = static_cast<float>(u * (level - signature_level));
    }
  });
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

// Map units per DN/s, but for the beam's own rate: relative to the first signature exposure.
double stack_factor(const Measurement& m, const Exposure& e) {
  return std::pow(10, stack_od(m, e) - stack_od(m, m.signatures.front()));
}

Reductions reduce_all(const Measurement& m, FrameSource& source, const Progress& progress, BrdfMap& map) {
  Reductions out;
  for (std::size_t e = 0; e < m.exposures.size(); ++e) {
    if (progress)
      progress("exposure " + std::to_string(e + 1),
               static_cast<double>(e + 1) / static_cast<double>(m.exposures.size() + 2));
    out.samples.push_back(source.reduce_exposure(m.exposures[e], "exposure " + std::to_string(e + 1)));
    out.factors.push_back(stack_factor(m, m.exposures[e]));
    map.exposures.push_back(out.samples.back().record);
    note_noise(out.samples.back().pooled_dark_noise_dn, map.exposures.back().role, source.sensor(), map);
  }
  return out;
}

std::vector<ScaledCounts> scaled(const Reductions& r) {
  std::vector<ScaledCounts> out;
  for (std::size_t e = 0; e < r.samples.size(); ++e)
    out.push_back({&r.samples[e].counts, r.factors[e], r.samples[e].dark_group});
  return out;
}

MergedSignature signature_of(const Measurement& m, const Reductions& beam) {
  try {
    return merge_signature(scaled(beam), m.aperture.radius_px);
  } catch (const Error& e) {
    throw with_context(m.file.string(), e);
  }
}

// What of the signature's exposures tells of the beam: elsewhere their pixels would add noise alone to the ratios.
std::vector<Counts> beam_counts(const Measurement& m, const Reductions& beam) {
  std::vector<Counts> out;
  if (beam.samples.empty()) return out;
  const Signature spot = signature_of(m, beam).beam;
  for (const FrameSource::Reduced& r : beam.samples)
    out.push_back(cropped(r.counts, beam_window(spot, r.counts.mask.rows(), r.counts.mask.columns())));
  return out;
}

// Measures the exposures' factors from their overlaps and applies them.
std::optional<OverlapReport> measure_overlap(const Measurement& m, const ExposureCauses& causes, Reductions& r,
                                             Beam& beam, BrdfMap& map) {
  bool any = false;
  for (std::size_t k = 0; k < causes.causes.size(); ++k) any = any || causes.is_measurable(k);
  if (!any) return std::nullopt;
  const std::vector<Counts> windows = beam_counts(m, beam.exposures);
  const std::vector<ScaledCounts> of_sample = scaled(r);
  std::vector<ScaledCounts> of_beam = scaled(beam.exposures);
  for (std::size_t j = 0; j < of_beam.size(); ++j) of_beam[j].counts = &windows[j];
  const std::vector<double> sample_level = levels_per_unit(m, r), beam_level = levels_per_unit(m, beam.exposures);
  const std::vector<OverlapGroup> groups{{of_sample, sample_level}, {of_beam, beam_level}};
  OverlapReport out{causes, solve_overlap(groups, causes, u_nonlinearity(m))};
  const Eigen::VectorXd of_samples = causes.sensitivity * out.solution.shift,
                        of_beams = causes.reference * out.solution.shift;
  for (std::size_t e = 0; e < r.factors.size(); ++e) r.factors[e] *= std::exp(of_samples[static_cast<Eigen::Index>(e)]);
  for (std::size_t j = 0; j < beam.exposures.factors.size(); ++j)
    beam.exposures.factors[j] *= std::exp(of_beams[static_cast<Eigen::Index>(j)] - of_beams[0]);
  note_overlap(out, map);
  return out;
}

// Causes of all exposures, the sample's relative to the first signature exposure.
ExposureCauses stated_causes(const Measurement& m) {
  std::vector<ScaleBudget> samples, signatures;
  for (const Exposure& e : m.exposures) samples.push_back(exposure_scale(m, e, {}));
  for (std::size_t j = 0; m.signatures.size() > 1 && j < m.signatures.size(); ++j)
    signatures.push_back(signature_scale(m, j));
  return causes_by_identity(samples, signatures);
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

// A single exposure is measured at once, so that its images need not be kept.
Beam reduce_beam(const Measurement& m, FrameSource& source, BrdfMap& map) {
  Beam out;
  Reductions& r = out.exposures;
  for (std::size_t j = 0; j < m.signatures.size(); ++j) {
    const std::string role = m.signatures.size() < 2 ? "signature" : "signature exposure " + std::to_string(j + 1);
    r.samples.push_back(source.reduce_exposure(m.signatures[j], role));
    r.factors.push_back(stack_factor(m, m.signatures[j]));
    map.exposures.push_back(r.samples.back().record);
    note_noise(r.samples.back().pooled_dark_noise_dn, role, source.sensor(), map);
  }
  if (r.samples.size() == 1) {
    out.measured = signature_of(m, r);
    r = {};
  }
  return out;
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

// What the beam adds to the causes: its filters, each exposure with its share, and its noise.
void refer_to_beam(const Measurement& m, const MergedSignature& signature, ExposureCauses& causes, BrdfResult& out) {
  note_beam(m, signature, out.map);
  out.signature = signature.beam;
  out.signature_share = signature.share;
  const double u_signature = signature.beam.u_rate_dn_per_s / signature.beam.rate_dn_per_s;
  for (const Exposure& e : m.exposures)
    out.exposure_scale.push_back(exposure_scale(m, e, {u_signature, signature.share}));
  causes.refer_to(signature.share);
  if (u_signature > 0) causes.add_common({"signature", Distribution::kNormal, u_signature, -1, false, 0});
}

// A map merged from exposures of different scenes would be that of the exposure with the least noise.
void require_one_scene(const Reductions& r, const std::vector<Exposure>& exposures, const std::string& role) {
  const auto found = contradiction(scaled(r));
  if (!found) return;
  throw Error({exposures[found->dim].where,
               "contradicts " + role + " " + std::to_string(found->bright + 1) +
                   ": where either sees light, it shows " +
                   number_text(std::max(0.0, std::round(found->ratio * 1e4) / 1e4)) + " of it",
               {},
               "the same light within a factor of 4 after filters and times: was a shutter closed?"});
}

// Several exposures, or one step by step.
void exact_map(const Measurement& m, FrameSource& source, Beam beam, FilterValues filters, const Progress& progress,
               BrdfResult& out) {
  BrdfMap& map = out.map;
  map.method = "exact";
  Reductions reductions = reduce_all(m, source, progress, map);
  require_one_scene(reductions, m.exposures, "exposure");
  require_one_scene(beam.exposures, m.signatures, "signature exposure");
  ExposureCauses causes = stated_causes(m);
  if (progress) progress("overlap", 0.8);
  if (filters == FilterValues::kByOverlap) out.overlap = measure_overlap(m, causes, reductions, beam, map);
  const MergedSignature signature = beam.measured ? *beam.measured : signature_of(m, beam.exposures);
  beam = {};
  for (double& factor : reductions.factors) factor /= signature.beam.rate_dn_per_s;
  refer_to_beam(m, signature, causes, out);
  if (progress) progress("map", 0.9);
  const Merged merged = merge(scaled(reductions));
  map.angles = angles_of(m);
  const Grid<double> expected = apply_geometry(merged, map);
  require_some_good_pixel(m, map);
  const Grid<float> nonlinearity = nonlinearity_change(m, levels_per_unit(m, reductions), signature, merged);
  split_causes(causes, out.overlap ? &out.overlap->solution : nullptr, {merged, expected, nonlinearity}, map);
  add_pose_uncertainty(m, expected, map);
}

// The pixels' non-linearity needs the counts behind the map: the expected BRDF times Ω cos theta_s.
void split_causes_of_one(const Measurement& m, const ExposureCauses& causes, const MergedSignature& signature,
                         double per_unit, const Grid<double>& expected_per_sr, BrdfMap& map) {
  Merged merged;
  if (!expected_per_sr.empty()) {
    merged.expected = Grid<double>(map.mask.rows(), map.mask.columns());
    for_each_row(map.mask.rows(), [&](int row) {
      for (int c = 0; c < map.mask.columns(); ++c) {
        merged.expected(row, c) =
            expected_per_sr(row, c) * map.angles.solid_angle_sr(row, c) * std::cos(map.angles.theta_s_rad(row, c));
      }
    });
  }
  const Grid<float> nonlinearity = nonlinearity_change(m, {per_unit}, signature, merged);
  split_causes(causes, nullptr, {merged, expected_per_sr, nonlinearity}, map);
}

// One exposure: from its frames to the map in one pass.
void fused_map_of(const Measurement& m, FrameSource& source, const MergedSignature& signature, const Progress& progress,
                  BrdfResult& out) {
  BrdfMap& map = out.map;
  const SampleView view = sample_view(m.instrument, m.pose);
  ExposureCauses causes = stated_causes(m);
  refer_to_beam(m, signature, causes, out);
  map.method = "fused";
  const Exposure& exposure = m.exposures.front();
  if (progress) progress("exposure 1", 0.4);
  FrameSource::Raw raw = source.read_exposure(exposure, "exposure 1");
  map.exposures.push_back(raw.record);
  note_noise(raw.pooled_dark_noise_dn, raw.record.role, source.sensor(), map);
  if (progress) progress("map", 0.8);
  const double factor = stack_factor(m, exposure) / signature.beam.rate_dn_per_s;
  std::optional<PoseTiles> pose;
  if (m.instrument.calibration && !m.instrument.calibration->parameters.empty())
    pose.emplace(view, calibration_changes(m.instrument, m.pose), m.instrument.rows, m.instrument.columns);
  FusedPlanes<double> planes;
  fused_map({raw.frames, raw.dark->master, source.sensor(), source.response(), exposure.exposure_s, factor},
            {view, nullptr, pose ? &*pose : nullptr}, {.with_total = false, .with_expected = u_nonlinearity(m) > 0},
            planes);
  raw = {};  // before the angles need memory
  map.brdf_per_sr = std::move(planes.brdf_per_sr);
  map.u_random_per_sr = std::move(planes.u_random_per_sr);
  map.u_pose_per_sr = std::move(planes.u_pose_per_sr);
  map.mask = std::move(planes.mask);
  require_some_good_pixel(m, map);
  map.angles = angles_of(m);
  split_causes_of_one(m, causes, signature, level_per_unit(m, exposure.exposure_s, factor), planes.expected_per_sr,
                      map);
}

}  // namespace

BrdfResult brdf_from_frames(const Measurement& m, const Progress& progress, FilterValues filters, BrdfMethod method) {
  BrdfResult out;
  BrdfMap& map = out.map;
  map.instrument = m.instrument;
  map.pose = m.pose;
  map.wavelength_m = m.wavelength_m;
  require_possible_pose(m);
  FrameSource source(m);
  if (progress) progress("signature", 0);
  Beam beam = reduce_beam(m, source, map);
  const bool plane = !m.instrument.lens_cameramodel;  // what the fused pass is made for
  if (method == BrdfMethod::kFused && plane && m.exposures.size() == 1 && beam.measured) {
    fused_map_of(m, source, *beam.measured, progress, out);
  } else {
    exact_map(m, source, std::move(beam), filters, progress, out);
  }
  map.notes.insert(map.notes.end(), source.notes().begin(), source.notes().end());
  note_darkness(map);
  note_power(map);
  return out;
}

}  // namespace scatmap
