#include <cmath>
#include <cstdio>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "scatmap/base/parallel.h"
#include "scatmap/base/units.h"
#include "scatmap/brdf/from_frames.h"
#include "scatmap/brdf/map_summary.h"
#include "scatmap/report/map_exr.h"
#include "scatmap/report/map_fits.h"
#include "tools/instrument_inputs.h"
#include "tools/output_options.h"
#include "tools/progress_bar.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

struct Options {
  std::string measurement;
  std::string precision = "single";
  bool no_overlap = false;
  std::string method;  ///< empty: not given
  OutputOptions output;
};

nlohmann::json filters_json(const ScaleBudget& b) {
  const ScaleInterval i = b.filters_interval();
  return {{"worst_case", b.filters_worst_case()}, {"standard", b.filters_standard()}, {"interval", {i.low, i.high}}};
}

// What the overlaps say of the causes that differ between exposures.
nlohmann::json overlap_json(const OverlapReport& o) {
  nlohmann::json out{{"causes", nlohmann::json::array()}, {"pairs", nlohmann::json::array()}};
  for (std::size_t k = 0; k < o.causes.causes.size(); ++k) {
    if (!o.causes.is_measurable(k)) continue;
    const auto i = static_cast<Eigen::Index>(k);
    out["causes"].push_back({{"cause", o.causes.causes[k].name},
                             {"u_stated", o.causes.causes[k].standard()},
                             {"shift", o.solution.shift[i]},
                             {"u", std::sqrt(o.solution.covariance(i, i))}});
  }
  for (const OverlapPair& p : o.solution.pairs) {
    const auto samples = static_cast<std::size_t>(o.causes.sensitivity.rows());
    const bool beam = p.a >= samples;
    const std::size_t first = beam ? samples : 0;
    nlohmann::json pair{{"of", beam ? "signature" : "sample"},
                        {"exposures", {p.a - first + 1, p.b - first + 1}},
                        {"used", p.used},
                        {"pixels", p.pixels}};
    if (p.pixels > 0) {
      pair.update({{"seam", p.ln_ratio}, {"u", p.u}, {"chi_squared_per_pixel", p.chi_squared}});
    }
    if (!p.problem.empty()) pair["problem"] = p.problem;
    out["pairs"].push_back(pair);
  }
  return out;
}

void print_overlap(const OverlapReport& o) {
  for (std::size_t k = 0; k < o.causes.causes.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (!o.causes.is_measurable(k) || !o.causes.causes[k].is_filter) continue;
    std::printf("%s by overlap: %+.5f OD from its stated value, standard uncertainty %.5f (stated %.5f)\n",
                o.causes.causes[k].name.c_str(), o.solution.shift[i], std::sqrt(o.solution.covariance(i, i)),
                o.causes.causes[k].standard());
  }
  for (const OverlapPair& p : o.solution.pairs) {
    if (!p.used) continue;
    std::printf("%s: %.0f common pixels, step %+.3f %% with a standard uncertainty of %.3f %%\n",
                pair_name(p, static_cast<std::size_t>(o.causes.sensitivity.rows())).c_str(), p.pixels, 100 * p.ln_ratio,
                100 * p.u);
  }
}

void print_json(const BrdfResult& r, const MapSummary& s) {
  nlohmann::json out{
      {"theta_i_deg", r.map.angles.theta_i_rad * kDegPerRad}, {"pixels", r.map.mask.size()}, {"good_pixels", s.good}};
  out["method"] = r.map.method;
  out["largest_per_sr"] = s.good > 0 ? nlohmann::json(s.largest) : nlohmann::json(nullptr);
  out["u_scale"] = r.map.scale.standard();
  out["filters_common"] = filters_json(r.map.scale);
  for (const ScaleBudget& b : r.exposure_scale) out["filters_per_exposure"].push_back(filters_json(b));
  for (const ScaleCause& c : r.map.scale.causes) {
    out["scale_causes"].push_back({{"cause", c.name},
                                   {"distribution", to_string(c.distribution)},
                                   {"half_width", c.half_width},
                                   {"sensitivity", c.sensitivity},
                                   {"u", c.standard()}});
  }
  for (const StructuredCause& c : r.map.structured)
    out["structured_causes"].push_back({{"extension", c.name}, {"cause", c.meaning}});
  out["signature"] = {{"rate_dn_per_s", r.signature.rate_dn_per_s},
                      {"u_rate_dn_per_s", r.signature.u_rate_dn_per_s},
                      {"column", r.signature.column},
                      {"row", r.signature.row},
                      {"radius_px", r.signature.radius_px},
                      {"replaced_pixels", r.signature.replaced_pixels},
                      {"share", r.signature_share}};
  if (r.overlap) out["overlap"] = overlap_json(*r.overlap);
  out["notes"] = r.map.notes;
  std::printf("%s\n", out.dump(2).c_str());
}

void print_text(const BrdfResult& r, const MapSummary& s) {
  std::printf("theta_i %.4f deg, %zu of %zu pixels good, largest BRDF %.4g sr^-1\n",
              r.map.angles.theta_i_rad * kDegPerRad, s.good, r.map.mask.size(), s.largest);
  std::printf("random and structured uncertainty: %.2f %% on average where f > 10 u\n", 100 * s.mean_relative);
  std::printf("scale, common to all pixels: %.2f %% standard\n", 100 * r.map.scale.standard());
  for (std::size_t e = 0; e < r.exposure_scale.size(); ++e) {
    const ScaleBudget& b = r.exposure_scale[e];
    const ScaleInterval i = b.filters_interval();
    std::printf("ND filters of exposure %zu: worst case %.1f %%, standard %.1f %%, interval %+.1f %% to %+.1f %%\n",
                e + 1, 100 * b.filters_worst_case(), 100 * b.filters_standard(), 100 * i.low, 100 * i.high);
  }
  if (r.overlap) print_overlap(*r.overlap);
  for (const std::string& note : r.map.notes) std::printf("note: %s\n", note.c_str());
}

const char* what_fused_lacks(const Measurement& m) {
  if (m.exposures.size() > 1) return "a single exposure";
  if (m.instrument.lens_cameramodel) return "a detector without a lens";
  return "a signature measured with frames";
}

std::vector<std::filesystem::path> files_of(const Measurement& m) {
  std::vector<std::filesystem::path> out{m.file, m.instrument_file};
  for (const auto* list : {&m.signatures, &m.exposures}) {
    for (const Exposure& e : *list) {
      out.insert(out.end(), e.frames.begin(), e.frames.end());
      out.insert(out.end(), e.darks.begin(), e.darks.end());
    }
  }
  for (const auto& file : {m.flat, m.bad_pixels}) {
    if (file) out.push_back(*file);
  }
  return out;
}

// The fused pass ends in float, which a map in double would show.
BrdfMethod method_of(const Options& o) {
  const bool exact = o.method.empty() ? o.precision == "double" : o.method == "exact";
  return exact ? BrdfMethod::kExact : BrdfMethod::kFused;
}

void run(const Options& o, const Invocation& invocation) {
  o.output.check();
  const Measurement measurement = read_measurement(o.measurement);
  o.output.keep(files_of(measurement));
  note_odd_size(measurement.instrument_file, measurement.instrument);
  std::vector<InputRecord> inputs = instrument_inputs(measurement.instrument_file, measurement.instrument);
  inputs.insert(inputs.begin(), record_input(o.measurement));
  BrdfResult result = brdf_from_frames(measurement, progress_bar("brdf"),
                                       o.no_overlap ? FilterValues::kNominal : FilterValues::kByOverlap, method_of(o));
  result.map.provenance = {invocation.command_line, "scatmap " + version(), inputs};
  // While the file system is waited for.
  std::future<MapSummary> summary = std::async(std::launch::async, [&] { return summarise(result.map); });
  for (const std::string& target : o.output.targets) {
    if (extension_of(target) == ".exr") {
      write_map_exr(result.map, target, o.output.overwrite());
    } else {
      write_map_fits(result.map, target, o.precision == "double" ? Precision::kDouble : Precision::kSingle,
                     o.output.overwrite());
    }
  }
  if (o.method == "fused" && result.map.method == "exact")
    std::fprintf(stderr, "note: method exact was used: fused is for %s\n", what_fused_lacks(measurement));
  const MapSummary s = summary.get();
  o.output.json ? print_json(result, s) : print_text(result, s);
}

}  // namespace

void setup_brdf(CLI::App& app, const Invocation& invocation) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("brdf", "raw frames to a BRDF map with uncertainty");
  verb->add_option("measurement", o->measurement, "measurement.toml")->required();
  verb->add_option("--precision", o->precision, "of the BRDF in FITS; uncertainties are single, angles double")
      ->check(CLI::IsMember({"single", "double"}))
      ->capture_default_str();
  verb->add_option(
          "--method", o->method,
          "fused: one pass over the frames of a single exposure, BRDF in single precision; exact: step by step, as "
          "several exposures always are")
      ->check(CLI::IsMember({"fused", "exact"}))
      ->default_str("fused, exact with --precision double");
  verb->add_flag("--no-overlap", o->no_overlap,
                 "merge exposures with the stated filters, not with those measured by overlap");
  o->output.add_to(*verb, "OUT.fits or OUT.exr; give -o twice for both", {".fits", ".fit", ".exr"});
  verb->callback([o, invocation] { run(*o, invocation); });
}

}  // namespace scatmap::tools
