#include "calib/calibrate.h"

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>

#include <nlohmann/json.hpp>

#include "calib/bootstrap.h"
#include "calib/report.h"
#include "scatmap/base/error.h"
#include "scatmap/base/provenance.h"
#include "scatmap/base/units.h"
#include "scatmap/report/residual_picture.h"
#include "tools/instrument_inputs.h"
#include "tools/output_options.h"
#include "tools/toml_comment.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

struct Options {
  std::string targets;
  std::string instrument;
  std::vector<std::string> priors;
  calib::CalibrateOptions calibrate;
  bool fit_all = false;
  std::string residuals;  // picture
  int bootstrap_trials = 0;
  std::string bootstrap_kind = "parametric";
  std::uint64_t bootstrap_seed = 1;
  OutputOptions output;
};

CLI::ValidationError second_thing(const std::string& option, const std::string& text) {
  return CLI::ValidationError(option, "'" + text + "' says a second thing about a parameter");
}

void read_prior(const std::string& text, calib::ParameterChoices& choices) {
  const auto equals = text.find('=');
  double sigma = 0;
  if (equals != std::string::npos) {
    const auto [end, error] = std::from_chars(text.data() + equals + 1, text.data() + text.size(), sigma);
    if (error == std::errc() && end == text.data() + text.size()) {
      if (choices.prior_sigma.emplace(text.substr(0, equals), sigma).second) return;
      throw second_thing("--prior", text);
    }
  }
  throw CLI::ValidationError("--prior", "'" + text + "' is not NAME=SIGMA, for example beam.offset_mm.0=0.1");
}

// Before the work: a fit is not thrown away over a name.
void check_picture(const Options& o) {
  if (o.residuals.empty()) return;
  const std::string extension = extension_of(o.residuals);
  if (extension != ".png" && extension != ".svg")
    throw Error({"--residuals", "names no picture format", o.residuals, ".png or .svg"});
  OutputFile(o.residuals, o.output.overwrite());  // written nothing, checked all
}

void draw_residuals(const calib::TargetList& list, const calib::CalibrationResult& r, const Options& o) {
  std::vector<SpotResidual> spots;
  for (std::size_t i = 0; i < list.targets.size(); ++i) {
    const calib::Target& t = list.targets[i];
    const calib::TargetResult& found = r.targets[i];
    spots.push_back({t.column_px, t.row_px, -found.residual_px[0], -found.residual_px[1], found.distance,
                     t.kind == calib::TargetKind::kDirect, !found.used});
  }
  draw_spot_residuals(spots, r.instrument.columns, r.instrument.rows, "spot less prediction, " + o.targets, o.residuals,
                      {o.output.overwrite(), false});
}

// What is wrong with the nominal file is named with it; what is wrong with targets names itself.
calib::CalibrationResult calibrated(const calib::TargetList& list, const Instrument& nominal, const Options& o) try {
  return calib::calibrate(list, nominal, o.calibrate);
} catch (const Error& e) {
  if (nominal.lens_cameramodel) throw with_context(o.instrument, e);
  throw;
}

calib::BootstrapKind bootstrap_kind(const Options& o) {
  if (o.bootstrap_kind == "residual") return calib::BootstrapKind::kResiduals;
  return o.bootstrap_kind == "case" ? calib::BootstrapKind::kCases : calib::BootstrapKind::kParametric;
}

nlohmann::json bootstrap_json(const calib::Bootstrap& b, const calib::CalibrationResult& r, const Options& o) {
  nlohmann::json out{
      {"kind", o.bootstrap_kind}, {"trials", b.trials}, {"failed", b.failed}, {"seed", o.bootstrap_seed}};
  for (const calib::DirectionSigma& d : b.directions) {
    out["directions"].push_back({{"where", d.point.where},
                                 {"stage_deg", d.point.pose.stage_rad * kDegPerRad},
                                 {"sigma_mrad", d.rad * 1e3},
                                 {"sigma_column_px", d.column_px},
                                 {"sigma_row_px", d.row_px}});
  }
  for (std::size_t k = 0; k < b.parameter_sigma.size(); ++k)
    out["parameters"][r.parameters[static_cast<std::size_t>(r.set[k].index)].name] = b.parameter_sigma[k];
  return out;
}

void print_bootstrap(const calib::Bootstrap& b, const calib::CalibrationResult& r, const Options& o) {
  std::printf(
      "\n%s bootstrap, %d trials, %d without a fit; standard uncertainty of directions, and by the covariance:\n",
      o.bootstrap_kind.c_str(), b.trials, b.failed);
  for (std::size_t k = 0; k < b.directions.size(); ++k) {
    const calib::DirectionSigma &d = b.directions[k], &c = r.directions[k];
    std::printf("  stage %8.3f deg, %-26s %9.4f mrad against %9.4f mrad\n", d.point.pose.stage_rad * kDegPerRad,
                (d.point.where + ":").c_str(), d.rad * 1e3, c.rad * 1e3);
  }
}

void print(const calib::TargetList& list, const calib::CalibrationResult& result,
           const std::optional<calib::Bootstrap>& scatter, const Options& o) {
  if (!o.output.json) {
    std::printf("%s\n", calib::report_text(list, result).c_str());
    if (scatter) print_bootstrap(*scatter, result, o);
    return;
  }
  if (!scatter) {
    std::printf("%s\n", calib::report_json(list, result).c_str());
    return;
  }
  auto out = nlohmann::ordered_json::parse(calib::report_json(list, result));
  out["bootstrap"] = bootstrap_json(*scatter, result, o);
  std::printf("%s\n", out.dump(2).c_str());
}

void run(Options o, const Invocation& invocation) {
  o.output.check();
  check_picture(o);
  for (const std::string& p : o.priors) read_prior(p, o.calibrate.choices);
  if (const auto twice = calib::doubled_choice(o.calibrate.choices)) throw second_thing(twice->option, twice->name);
  o.calibrate.select = !o.fit_all;
  const Instrument nominal = read_instrument(o.instrument);
  note_odd_size(o.instrument, nominal);
  const calib::TargetList list = calib::read_targets(o.targets);
  const Provenance provenance{
      invocation.command_line, "scatmap " + version(), {record_input(o.targets), record_input(o.instrument)}};
  const calib::CalibrationResult result = calibrated(list, nominal, o);
  const std::string text = toml_comment(provenance) + to_toml(result.instrument);
  std::optional<calib::Bootstrap> scatter;
  if (o.bootstrap_trials > 0)
    scatter = calib::bootstrap(list, result, {bootstrap_kind(o), o.bootstrap_trials, o.bootstrap_seed});
  if (!o.residuals.empty()) draw_residuals(list, result, o);
  for (const std::string& target : o.output.targets) write_text_file(target, text, o.output.overwrite());
  print(list, result, scatter, o);
}

}  // namespace

void setup_calibrate(CLI::App& app, const Invocation& invocation) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("calibrate", "known specular targets to a calibrated instrument with covariance");
  verb->add_option("targets", o->targets, "targets.csv")->required();
  verb->add_option("--instrument", o->instrument, "nominal instrument.toml")->required();
  verb->add_option("--free", o->calibrate.choices.free,
                   "NAME: always fit this parameter, without a prior; may be repeated")
      ->allow_extra_args(false);
  verb->add_option("--fix", o->calibrate.choices.fix, "NAME: keep this parameter at its nominal value; may be repeated")
      ->allow_extra_args(false);
  verb->add_option("--prior", o->priors,
                   "NAME=SIGMA: always fit this parameter, known beforehand to SIGMA (file units); may be repeated")
      ->allow_extra_args(false);
  verb->add_flag("--all", o->fit_all, "fit every parameter, needed or not");
  verb->add_option("--reject-sigma", o->calibrate.reject_sigma, "leave out targets further off than this")
      ->check(CLI::Range(2.0, 1e6) & finite_number())
      ->capture_default_str();
  verb->add_option("--tolerance-px", o->calibrate.tolerance_px,
                   "directions may be off by this for parameters that the targets do not see")
      ->check(non_negative_number())
      ->capture_default_str();
  verb->add_option("--bootstrap", o->bootstrap_trials, "fits this often anew and states the scatter of directions")
      ->check(CLI::Range(2, 10'000'000));
  verb->add_option(
          "--bootstrap-kind", o->bootstrap_kind,
          "parametric: new noise as stated; residual: the fit's own residuals; case: settings with replacement")
      ->check(CLI::IsMember({"parametric", "residual", "case"}))
      ->capture_default_str();
  verb->add_option("--seed", o->bootstrap_seed, "of the bootstrap")->capture_default_str();
  verb->add_option("--residuals", o->residuals,
                   "picture (PNG or SVG): an arrow on the frame for every spot, outliers marked");
  o->output.add_to(*verb, "calibrated.toml", {".toml"});
  verb->footer(
      "Where targets are blind, mechanical tolerances count as measurements (standard deviations, file units; a mirror "
      "mount has the sample's): " +
      calib::default_priors() +
      ".\nWith one mirror mount the calibrated sample tilt and height are that mount's; with several they stay "
      "nominal.");
  verb->callback([o, invocation] { run(*o, invocation); });
}

}  // namespace scatmap::tools
