#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "calib/export_cameramodel.h"
#include "calib/instrument_from_poni.h"
#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "tools/instrument_inputs.h"
#include "tools/output_options.h"
#include "tools/toml_comment.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string input;
  std::string instrument;  // of a .poni file
  double stage_deg = 0, arm_deg = 0;
  OutputOptions output;

  Pose pose() const { return {stage_deg * kRadPerDeg, arm_deg * kRadPerDeg}; }
};

std::string provenance_lines(const Invocation& invocation, const std::vector<InputRecord>& inputs) {
  std::string text = "scatmap " + version() + "\n" + invocation.command_line + "\n";
  for (const InputRecord& i : inputs) text += "input " + i.path + " sha256 " + i.sha256 + "\n";
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ' && c != '\n') c = ' ';
  }
  return text;
}

// The formats have no word for it; maps mask such pixels.
void note_back(const SampleView& view, const Instrument& in) {
  const Vector3<double> middle = view.pixel(0.5 * (in.columns - 1), 0.5 * (in.rows - 1));
  if (view.detector_normal.dot(middle) > 0) return;
  std::fprintf(stderr, "note: the detector turns its back to the sample: this is its view through the back\n");
}

std::string exported(const Options& o, const std::string& extension, const Invocation& invocation) try {
  const Instrument in = read_instrument(o.input);
  if (in.lens_cameramodel)
    throw Error({"detector.lens_cameramodel", "is a camera model already; only a bare detector is exported", {}, {}});
  const SampleView view = sample_view(in, o.pose());
  note_back(view, in);
  const std::string comment = provenance_lines(invocation, instrument_inputs(o.input, in));
  if (extension == ".poni") return calib::to_poni(calib::poni_at_spot(view, in.columns, in.rows), comment);
  return calib::to_cameramodel(calib::pinhole_at_spot(view, in.columns, in.rows), comment);
} catch (const Error& e) {
  throw e.detail().where.starts_with(o.input) ? e : with_context(o.input, e);
}

// A detector of as many pixels, but another one: the same file's size would say nothing.
void note_other_pitch(const Instrument& of_file, const Instrument& like, const Options& o) {
  constexpr double kSame = 0.01;
  const Geometry<double>&a = of_file.geometry, &b = like.geometry;
  if (std::abs(a.pixel_column - b.pixel_column) <= kSame * b.pixel_column &&
      std::abs(a.pixel_row - b.pixel_row) <= kSame * b.pixel_row)
    return;
  std::fprintf(stderr, "note: %s says pixels of %g um x %g um, %s %g um x %g um: the first is kept; one detector?\n",
               o.input.c_str(), a.pixel_column / kMetrePerUm, a.pixel_row / kMetrePerUm, o.instrument.c_str(),
               b.pixel_column / kMetrePerUm, b.pixel_row / kMetrePerUm);
}

// Metres and millimetres, or the pose of another file.
void note_other_distance(const Instrument& of_file, const Instrument& like, const Options& o) {
  constexpr double kFar = 2, kAside = 0.25;
  const Geometry<double>&a = of_file.geometry, &b = like.geometry;
  const double ratio = a.distance / b.distance;
  const double aside = std::hypot(a.offset_x - b.offset_x, a.offset_y - b.offset_y) / b.distance;
  if (ratio < kFar && ratio > 1 / kFar && aside < kAside &&
      std::max(std::abs(a.rotation_pitch - b.rotation_pitch), std::abs(a.rotation_yaw - b.rotation_yaw)) < kAside)
    return;
  std::fprintf(stderr,
               "note: %s puts the detector at %g mm, offset by %g and %g mm; %s at %g mm, by %g and %g mm: units, and "
               "this pose?\n",
               o.input.c_str(), a.distance / kMetrePerMm, a.offset_x / kMetrePerMm, a.offset_y / kMetrePerMm,
               o.instrument.c_str(), b.distance / kMetrePerMm, b.offset_x / kMetrePerMm, b.offset_y / kMetrePerMm);
}

std::string imported(const Options& o, const Invocation& invocation) {
  if (o.instrument.empty())
    throw Error({o.input, "holds the detector only", {}, "--instrument with arm, stage, beam and sample"});
  const Instrument like = read_instrument(o.instrument);
  const calib::Poni poni = calib::read_poni(o.input);
  const Provenance provenance{
      invocation.command_line, "scatmap " + version(), {record_input(o.input), record_input(o.instrument)}};
  try {
    const Instrument out = calib::instrument_from_poni(poni, like, o.pose());
    sample_view(out, o.pose());
    note_other_pitch(out, like, o);
    note_other_distance(out, like, o);
    if (like.calibration)
      std::fprintf(stderr, "note: the calibration in %s is left out: it describes another detector\n",
                   o.instrument.c_str());
    return toml_comment(provenance) + to_toml(out);
  } catch (const Error& e) {
    throw with_context(o.input + " with " + o.instrument, e);
  }
}

void run(const Options& o, const Invocation& invocation) {
  o.output.check();
  if (extension_of(o.input) == ".cameramodel")
    throw Error({o.input, "is a camera model: reading .cameramodel is not offered", {}, "an instrument file or .poni"});
  const bool from_poni = extension_of(o.input) == ".poni";
  for (const std::string& target : o.output.targets) {
    const std::string extension = extension_of(target);
    if (from_poni != (extension == ".toml"))
      throw Error({target, "cannot be made from " + o.input, extension,
                   from_poni ? ".toml, from a .poni file" : ".cameramodel or .poni, from an instrument file"});
  }
  if (!from_poni && !o.instrument.empty())
    throw Error({"--instrument", "goes with a .poni file only", o.instrument, {}});
  for (const std::string& target : o.output.targets) {
    const std::string text = from_poni ? imported(o, invocation) : exported(o, extension_of(target), invocation);
    write_text_file(target, text, o.output.overwrite());
    if (!o.output.json) std::printf("wrote %s\n", target.c_str());
  }
  if (o.output.json) std::printf("%s\n", nlohmann::json{{"written", o.output.targets}}.dump(2).c_str());
}

}  // namespace

void setup_export(CLI::App& app, const Invocation& invocation) {
  auto o = std::make_shared<Options>();
  CLI::App* verb =
      app.add_subcommand("export", "an instrument as a camera model of mrcal or a .poni file of pyFAI, and back");
  verb->add_option("input", o->input, "instrument.toml, or FILE.poni to read back")->required();
  verb->add_option("--stage-deg", o->stage_deg, "commanded stage angle of the pose")->required()->check(angle_range());
  verb->add_option("--arm-deg", o->arm_deg, "commanded arm angle of the pose")->required()->check(angle_range());
  verb->add_option("--instrument", o->instrument,
                   "with a .poni file: instrument.toml for all that such a file does not hold");
  o->output.add_to(*verb, "FILE.cameramodel or FILE.poni; FILE.toml from a .poni file",
                   {".cameramodel", ".poni", ".toml"});
  verb->footer(
      "Both formats describe the detector of one pose, seen from the illuminated spot: a pinhole camera whose "
      "reference "
      "frame is the sample's axes; 2theta and chi about the sample normal, 2theta being theta_s.");
  verb->callback([o, invocation] { run(*o, invocation); });
}

}  // namespace scatmap::tools
