#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "scatmap/angles/angle_method.h"
#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/angle_uncertainty.h"
#include "scatmap/angles/frame_extent.h"
#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/parallel.h"
#include "scatmap/base/units.h"
#include "scatmap/report/map_exr.h"
#include "scatmap/report/map_fits.h"
#include "tools/instrument_inputs.h"
#include "tools/output_options.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

struct Options {
  std::string instrument;
  double stage_deg = 0;
  double arm_deg = 0;
  std::string method;
  double tolerance_px = 0;  ///< 0: not given
  OutputOptions output;
};

struct Range {
  double low = HUGE_VAL, high = -HUGE_VAL;
};

Range range_deg(const Grid<double>& rad) {
  Range r;
  for (const double v : rad) {
    if (v * kDegPerRad < r.low) r.low = v * kDegPerRad;
    if (v * kDegPerRad > r.high) r.high = v * kDegPerRad;
  }
  return r;
}

void print(const AngleMap& map, const std::optional<AngleMethodNote>& note, bool json) {
  std::size_t good = 0;
  for (const Mask m : map.mask) good += m == 0;
  const Range theta = range_deg(map.theta_s_rad), phi = range_deg(map.phi_s_rad);
  if (json) {
    const auto number = [good](double v) { return good > 0 ? nlohmann::json(v) : nlohmann::json(nullptr); };
    nlohmann::json out{{"theta_i_deg", map.theta_i_rad * kDegPerRad},
                       {"pixels", map.mask.size()},
                       {"good_pixels", good},
                       {"theta_s_deg", {number(theta.low), number(theta.high)}},
                       {"phi_s_deg", {number(phi.low), number(phi.high)}},
                       {"method", note ? note->method : "mrcal"},
                       {"bound_rad", note ? nlohmann::json(note->bound_rad) : nlohmann::json()},
                       {"bound_px", note ? nlohmann::json(note->bound_px) : nlohmann::json()}};
    std::printf("%s\n", out.dump(2).c_str());
    return;
  }
  std::printf("theta_i %.6f deg, %zu of %zu pixels see the sample's front\n", map.theta_i_rad * kDegPerRad, good,
              map.mask.size());
  if (good > 0)
    std::printf("theta_s %.6f to %.6f deg, phi_s %.6f to %.6f deg\n", theta.low, theta.high, phi.low, phi.high);
  if (note) {
    std::printf("method %s, bound %.2e px (%.2e rad)\n", note->method.c_str(), note->bound_px, note->bound_rad);
  } else {
    std::printf("method mrcal, through the lens\n");
  }
}

double default_tolerance_px(const Instrument& instrument, const Pose& pose) {
  const auto sigma_px = smallest_direction_sigma_px(instrument, pose);
  return sigma_px && *sigma_px > 0 ? kToleranceShare * *sigma_px : kDefaultTolerance_px;
}

// Files hold degrees: float32 images are rounded once more.
double file_rounding_rad(const SampleView& view, const Instrument& instrument) {
  const FrameExtent e = frame_extent(view, instrument.rows, instrument.columns);
  constexpr double kHalfUnit = 6e-8;
  return kHalfUnit * std::hypot(e.theta_max_rad, e.phi_max_rad * std::sin(e.theta_max_rad));
}

double tolerance_of(const Options& o, const Instrument& instrument, const Pose& pose) {
  return o.tolerance_px > 0 ? o.tolerance_px : default_tolerance_px(instrument, pose);
}

AngleChoice choice_of(const Options& o, const Instrument& in, double tolerance_px, const SampleView& view) {
  const double rounding_rad = file_rounding_rad(view, in);
  const double per_px = frame_extent(view, in.rows, in.columns).pixel_step_rad;
  const double left_px = std::max(0.0, tolerance_px - rounding_rad / per_px);
  AngleChoice choice = o.method.empty() ? choose_angle_method(view, in.rows, in.columns, left_px)
                                        : with_method(*angle_method(o.method), view, in.rows, in.columns, left_px);
  if (!fills_single(choice.method)) return choice;
  choice.bound_rad += rounding_rad;
  choice.bound_px += rounding_rad / per_px;
  return choice;
}

AngleMap widened(const AngleMapOf<float>& narrow, const SampleView& view) {
  const int rows = narrow.mask.rows(), columns = narrow.mask.columns();
  AngleMap map{narrow.theta_i_rad, {rows, columns}, {rows, columns}, {rows, columns}, narrow.mask};
  for_each_row(rows, [&](int r) {
    std::copy_n(narrow.theta_s_rad.row(r).begin(), columns, map.theta_s_rad.row(r).begin());
    std::copy_n(narrow.phi_s_rad.row(r).begin(), columns, map.phi_s_rad.row(r).begin());
    AngleRow<double> rest;
    rest.solid_angle_sr = map.solid_angle_sr.row(r);
    angle_row(view, r, {0, columns}, rest);
  });
  return map;
}

AngleMap angles_by(const AngleChoice& choice, const SampleView& view, int rows, int columns) {
  if (fills_single(choice.method)) {
    AngleMapOf<float> map{0, {rows, columns}, {rows, columns}, {}, {rows, columns}};
    write_angle_map(view, choice, map);
    return widened(map, view);
  }
  AngleMap map{0, {rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}};
  write_angle_map(view, choice, map);
  return map;
}

struct Computed {
  AngleMap map;
  std::optional<AngleMethodNote> note;   // none behind a lens
  std::optional<double> missed_px = {};  // the tolerance that no method meets
};

Computed angles_of(const Options& o, const Instrument& instrument, const Pose& pose) try {
  if (instrument.lens_cameramodel) {
    if (!o.method.empty() || o.tolerance_px > 0)
      throw Error({"detector.lens_cameramodel", "leaves no choice of method: its rays are mrcal's", {}, {}});
    return {angle_map(instrument, pose), std::nullopt};
  }
  const SampleView view = sample_view(instrument, pose);
  const double tolerance_px = tolerance_of(o, instrument, pose);
  const AngleChoice choice = choice_of(o, instrument, tolerance_px, view);
  if (!std::isfinite(choice.bound_rad))
    throw Error({"--method " + o.method,
                 "has no bound at this pose: the pole lies in or near the frame",
                 {},
                 "another method"});
  constexpr double kRounding = 1e-9;  // tile's bound is what is left of the tolerance, and the file's rounding again
  const bool missed = o.method.empty() && !(choice.bound_px <= tolerance_px * (1 + kRounding));
  return {angles_by(choice, view, instrument.rows, instrument.columns),
          AngleMethodNote{std::string(to_string(choice.method)), choice.bound_rad, choice.bound_px,
                          fills_single(choice.method) ? Precision::kSingle : Precision::kDouble},
          missed ? std::optional(tolerance_px) : std::nullopt};
} catch (const Error& e) {
  throw with_context(o.instrument, e);
}

void print_notes(const Computed& angles, const Instrument& instrument) {
  if (instrument.lens_cameramodel && instrument.calibration)
    std::fprintf(
        stderr,
        "note: uncertainties of angles are left out: the calibration describes a flat detector, not one with a lens\n");
  if (angles.missed_px)
    std::fprintf(stderr, "note: no method meets %s px: %s, bound %.2e px\n", number_text(*angles.missed_px).c_str(),
                 angles.note->method.c_str(), angles.note->bound_px);
  const auto& mask = angles.map.mask;
  if (std::all_of(mask.begin(), mask.end(), [](Mask m) { return m != 0; }))
    std::fprintf(stderr, "note: no pixel sees the sample's front at this pose\n");
}

void run(const Options& o, const Invocation& invocation) {
  o.output.check();
  const Instrument instrument = read_instrument(o.instrument);
  note_odd_size(o.instrument, instrument);
  const Provenance provenance{invocation.command_line, "scatmap " + version(),
                              instrument_inputs(o.instrument, instrument)};
  const Pose pose{o.stage_deg * kRadPerDeg, o.arm_deg * kRadPerDeg};
  const Computed angles = angles_of(o, instrument, pose);
  for (const std::string& target : o.output.targets) {
    if (extension_of(target) == ".exr") {
      write_angles_exr(angles.map, provenance, target, o.output.overwrite());
    } else {
      write_angles_fits(angles.map, instrument, pose, provenance, target, o.output.overwrite(), angles.note);
    }
  }
  print_notes(angles, instrument);
  print(angles.map, angles.note, o.output.json);
}

std::vector<std::string> method_names() {
  std::vector<std::string> out;
  for (const AngleMethod method : angle_methods()) out.emplace_back(to_string(method));
  return out;
}

}  // namespace

void setup_angles(CLI::App& app, const Invocation& invocation) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("angles", "per-pixel scatter angles and solid angles of an instrument at a pose");
  verb->add_option("instrument", o->instrument, "instrument.toml")->required();
  verb->add_option("--stage-deg", o->stage_deg, "commanded stage angle")->required()->check(angle_range());
  verb->add_option("--arm-deg", o->arm_deg, "commanded arm angle")->required()->check(angle_range());
  CLI::Option* tolerance =
      verb->add_option(
              "--tolerance-px", o->tolerance_px,
              "largest error of a direction; takes the fastest method whose bound meets it (default: a tenth of "
              "the calibration's uncertainty, or 0.001)")
          ->check(CLI::Range(1e-12, 1e6));
  verb->add_option("--method", o->method, "this method in place of the fastest")
      ->check(CLI::IsMember(method_names()))
      ->excludes(tolerance);
  o->output.add_to(*verb, "OUT.fits or OUT.exr; give -o twice for both", {".fits", ".fit", ".exr"});
  verb->callback([o, invocation] { run(*o, invocation); });
}

}  // namespace scatmap::tools
