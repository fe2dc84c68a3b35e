#include "calib/calibrate.h"

#include <charconv>
#include <cstdio>
#include <memory>

#include "calib/report.h"
#include "scatmap/base/error.h"
#include "scatmap/base/provenance.h"
#include "tools/output_options.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

struct Options {
  std::string targets;
  std::string instrument;
  std::vector<std::string> priors;
  calib::CalibrateOptions calibrate;
  bool fit_all = false;
  OutputOptions output;
};

void read_prior(const std::string& text, calib::ParameterChoices& choices) {
  const auto equals = text.find('=');
  double sigma = 0;
  if (equals != std::string::npos) {
    const auto [end, error] = std::from_chars(text.data() + equals + 1, text.data() + text.size(), sigma);
    if (error == std::errc() && end == text.data() + text.size()) {
      if (choices.prior_sigma.emplace(text.substr(0, equals), sigma).second) return;
      throw CLI::ValidationError("--prior", "'" + text + "' says a second thing about a parameter");
    }
  }
  throw CLI::ValidationError("--prior", "'" + text + "' is not NAME=SIGMA, for example beam.offset_mm.0=0.1");
}

std::string comment_line(const std::string& name, std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return "# " + name + ": " + text + "\n";
}

std::string provenance_comment(const Provenance& p) {
  std::string text = comment_line("written by", p.written_by) + comment_line("command", p.command_line);
  for (const InputRecord& i : p.inputs) text += comment_line("input", i.path + " sha256 " + i.sha256);
  return text;
}

void run(Options o, const Invocation& invocation) {
  o.output.check();
  for (const std::string& p : o.priors) read_prior(p, o.calibrate.choices);
  o.calibrate.select = !o.fit_all;
  const Instrument nominal = read_instrument(o.instrument);
  const calib::TargetList list = calib::read_targets(o.targets);
  const Provenance provenance{
      invocation.command_line, "scatmap " + version(), {record_input(o.targets), record_input(o.instrument)}};
  const calib::CalibrationResult result = calib::calibrate(list, nominal, o.calibrate);
  const std::string text = provenance_comment(provenance) + to_toml(result.instrument);
  for (const std::string& target : o.output.targets) write_text_file(target, text, o.output.overwrite());
  std::printf("%s\n", (o.output.json ? calib::report_json(list, result) : calib::report_text(list, result)).c_str());
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
      ->check(CLI::NonNegativeNumber & finite_number())
      ->capture_default_str();
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
