#include <algorithm>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "calib/spots.h"
#include "calib/spots_setting.h"
#include "calib/targets.h"
#include "scatmap/angles/instrument.h"
#include "scatmap/base/error.h"
#include "scatmap/base/provenance.h"
#include "scatmap/base/units.h"
#include "scatmap/counts/dark.h"
#include "tools/output_options.h"
#include "tools/progress_bar.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> frames;
  std::vector<std::string> darks;
  std::string instrument;
  std::string angles;
  std::string method = "ml";
  std::optional<double> gain_e_per_dn, read_noise_e, saturation_dn;
  std::optional<double> stage_deg, arm_deg, tilt_deg;
  std::optional<std::string> kind, mount;
  OutputOptions output;
};

struct MeasuredFrame {
  fs::path file;
  calib::SpotsInFrame found;
  std::vector<std::string> notes;  ///< on what the frame is said to be
};

double stated(const std::optional<double>& option, const std::optional<double>& instrument,
              const std::optional<double>& header, const std::string& file, const char* what, const char* flag) {
  if (option) return *option;
  if (instrument) return *instrument;
  if (header) return *header;
  throw Error({file, std::string("nothing states the sensor's ") + what, {}, std::string("--instrument or ") + flag});
}

SensorModel sensor_of(const Options& o, const std::optional<Instrument>& instrument, const Frame& frame) {
  const Sensor s = instrument ? instrument->sensor : Sensor{};
  const std::string file = frame.file.string();
  return {stated(o.gain_e_per_dn, s.gain_e_per_dn, frame.header.gain_e_per_dn, file, "gain", "--gain-e-per-dn"),
          stated(o.read_noise_e, s.read_noise_e, {}, file, "read noise", "--read-noise-e"),
          stated(o.saturation_dn, s.saturation_dn, frame.header.saturation_dn, file, "saturation", "--saturation-dn"),
          s.bias_dn, s.linearity};
}

void check_size(const Frame& f, const std::optional<Instrument>& instrument) {
  if (!instrument || (f.dn.columns() == instrument->columns && f.dn.rows() == instrument->rows)) return;
  throw Error({f.file.string(), "has the wrong size",
               std::to_string(f.dn.columns()) + " x " + std::to_string(f.dn.rows()),
               std::to_string(instrument->columns) + " x " + std::to_string(instrument->rows) +
                   " as detector.columns and rows say"});
}

// Frames and darks must have the same exposure time where both state one.
void check_exposure(const Frame& frame, const std::vector<Frame>& darks) {
  for (const Frame& d : darks) {
    require_same_shape(frame, d);
    if (!frame.header.exposure_s || !d.header.exposure_s) continue;
    if (std::abs(*frame.header.exposure_s - *d.header.exposure_s) <= 1e-3 * *frame.header.exposure_s) continue;
    throw Error({d.file.string() + ": EXPTIME", "is not the exposure time of " + frame.file.string(),
                 std::to_string(*d.header.exposure_s) + " s", std::to_string(*frame.header.exposure_s) + " s"});
  }
}

// Before the targets are written that calibrate would refuse.
void check_mount(const std::optional<std::string>& mount) {
  if (!mount || calib::is_mount_name(*mount)) return;
  throw CLI::ValidationError("--mount", "'" + *mount + "' is not made of letters, digits, '-', '_', '.' and spaces");
}

calib::SpotSetting command_line_setting(const Options& o) {
  calib::SpotSetting s{{}, o.stage_deg, o.arm_deg, o.tilt_deg, o.mount};
  if (o.kind) s.kind = calib::parse_kind(*o.kind, "--kind");
  const bool any = s.kind || s.stage_deg || s.arm_deg || s.tilt_deg || s.mount;
  if (any && o.frames.size() > 1) {
    throw Error({"--stage-deg, --arm-deg, --tilt-deg, --kind, --mount", "describe one frame",
                 std::to_string(o.frames.size()) + " frames", "--angles angles.csv for several"});
  }
  return s;
}

// A path as targets.csv states it: relative to its own folder.
std::string path_beside(const fs::path& frame, const fs::path& csv) {
  const fs::path folder = fs::absolute(csv).parent_path();
  const std::string path = fs::proximate(fs::absolute(frame), folder).generic_string();
  if (path.find_first_of(",\"\n\r") == std::string::npos) return path;
  throw Error(
      {frame.string(), "cannot stand in a CSV file: its name has a comma, quotation mark or line break", {}, {}});
}

std::string flag_names(calib::SpotFlags flags) {
  std::string out;
  for (const calib::SpotFlag& f : calib::kSpotFlags) {
    if ((flags & f.bit) != 0) out += (out.empty() ? "" : ", ") + std::string(f.name);
  }
  return out;
}

nlohmann::json spot_json(const calib::Spot& s) {
  nlohmann::json flags = nlohmann::json::array();
  for (const calib::SpotFlag& f : calib::kSpotFlags) {
    if ((s.flags & f.bit) != 0) flags.push_back(f.name);
  }
  const auto& c = s.covariance_px2;
  return {{"column_px", s.column_px},
          {"row_px", s.row_px},
          {"sigma_px", s.sigma_px()},
          {"sigma_column_px", std::sqrt(c(0, 0))},
          {"sigma_row_px", std::sqrt(c(1, 1))},
          {"covariance_px2", {{c(0, 0), c(0, 1)}, {c(1, 0), c(1, 1)}}},
          {"flux_e", s.flux_e},
          {"u_flux_e", s.u_flux_e},
          {"width_major_px", s.axes.major_px},
          {"width_minor_px", s.axes.minor_px},
          {"angle_deg", s.axes.angle_rad * kDegPerRad},
          {"background_e", s.background_e},
          {"chi2", s.chi2},
          {"degrees_of_freedom", s.degrees_of_freedom},
          {"flags", flags}};
}

std::string why_without_spot(const MeasuredFrame& f) {
  std::string out = "no spot stands out";
  for (const std::string& d : f.found.dropped) out += "; " + d;
  return out;
}

void print_json(const std::vector<MeasuredFrame>& frames, const std::string& method) {
  nlohmann::json out{{"method", method}, {"frames", nlohmann::json::array()}, {"skipped", nlohmann::json::array()}};
  for (const MeasuredFrame& f : frames) {
    if (f.found.spots.empty()) out["skipped"].push_back({{"file", f.file.string()}, {"reason", why_without_spot(f)}});
    nlohmann::json spots = nlohmann::json::array();
    for (const calib::Spot& s : f.found.spots) spots.push_back(spot_json(s));
    out["frames"].push_back({{"file", utf8_text(f.file.string())},
                             {"spots", spots},
                             {"hot_pixels", f.found.hot_pixels},
                             {"dropped", f.found.dropped},
                             {"notes", f.notes}});
  }
  std::printf("%s\n", out.dump(2).c_str());
}

void print_text(const std::vector<MeasuredFrame>& frames) {
  for (const MeasuredFrame& f : frames) {
    if (f.found.spots.empty()) continue;
    const calib::Spot& s = f.found.spots.front();
    std::printf("%s: column %.3f, row %.3f, sigma %.4f px, %.4g electrons, widths %.2f and %.2f px\n", f.file.c_str(),
                s.column_px, s.row_px, s.sigma_px(), s.flux_e, s.axes.major_px, s.axes.minor_px);
  }
}

void print_notes(const std::vector<MeasuredFrame>& frames) {
  for (const MeasuredFrame& f : frames) {
    for (const std::string& n : f.notes) std::fprintf(stderr, "note: %s: %s\n", f.file.c_str(), n.c_str());
    if (f.found.spots.empty()) {
      std::fprintf(stderr, "skipped: %s: %s\n", f.file.c_str(), why_without_spot(f).c_str());
      continue;
    }
    for (const calib::SpotFlag& flag : calib::kSpotFlags) {
      if ((f.found.spots.front().flags & flag.bit) != 0)
        std::fprintf(stderr, "note: %s: the spot %s\n", f.file.c_str(), flag.meaning);
    }
    for (std::size_t i = 1; i < f.found.spots.size(); ++i) {
      const calib::Spot& s = f.found.spots[i];
      std::fprintf(stderr, "note: %s: another spot at column %.1f, row %.1f, %.2g of the strongest (%s)\n",
                   f.file.c_str(), s.column_px, s.row_px, s.flux_e / f.found.spots.front().flux_e,
                   flag_names(s.flags).c_str());
    }
    for (const std::string& d : f.found.dropped) std::fprintf(stderr, "note: %s: %s\n", f.file.c_str(), d.c_str());
  }
}

// A frame without a spot is no target; without any there is nothing to write.
void require_some_spot(const std::vector<MeasuredFrame>& frames) {
  std::string empty;
  for (const MeasuredFrame& f : frames) {
    if (!f.found.spots.empty()) return;
    empty += (empty.empty() ? "" : "; ") + f.file.string();
    for (const std::string& d : f.found.dropped) empty += " (" + d + ")";
  }
  throw Error({"spots", "no spot stands out", empty, "frames of one bright spot each"});
}

// A line break in a file's name must not end the comment that names it.
std::string in_one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return text;
}

std::string header_lines(const Options& o, const Invocation& invocation) {
  std::string out = "# scatmap " + version() + "\n# " + in_one_line(invocation.command_line) + "\n";
  const auto add = [&](const std::string& path) {
    out += "# input " + in_one_line(path) + " sha256 " + record_input(path).sha256 + "\n";
  };
  for (const std::string& f : o.frames) add(f);
  for (const std::string& d : o.darks) add(d);
  if (!o.instrument.empty()) add(o.instrument);
  if (!o.angles.empty()) add(o.angles);
  return out +
         "# column_px, row_px: centroid, (0, 0) is the centre of the first pixel stored; sigma_px: standard "
         "uncertainty, each axis\n";
}

class SpotFinder {
 public:
  explicit SpotFinder(const Options& o) : options_(o) {
    if (!o.instrument.empty()) instrument_ = read_instrument(o.instrument);
    for (const std::string& d : o.darks) {
      darks_.push_back(read_frame(d));
      require_dark(darks_.back());
    }
  }

  calib::SpotsInFrame find(const Frame& frame) {
    check_size(frame, instrument_);
    check_exposure(frame, darks_);
    const SensorModel sensor = sensor_of(options_, instrument_, frame);
    if (!darks_.empty() && (!dark_ || dark_gain_ != sensor.gain_e_per_dn)) {
      dark_ = combine_darks(darks_, sensor);
      dark_gain_ = sensor.gain_e_per_dn;
    }
    return calib::find_spots(calib::spot_image(frame, dark_, sensor), options_.method == "ml"
                                                                          ? calib::SpotMethod::kMaximumLikelihood
                                                                          : calib::SpotMethod::kMoments);
  }

 private:
  const Options& options_;
  std::optional<Instrument> instrument_;
  std::vector<Frame> darks_;
  std::optional<MasterDark> dark_;
  double dark_gain_ = 0;
};

calib::SpotSetting setting_of(const Frame& frame, const calib::SpotSetting& stated,
                              const std::optional<calib::SettingTable>& table) {
  calib::SpotSetting s = stated;
  if (table) {
    if (const auto line = table->find(frame.file)) s = calib::combined(s, *line);
  }
  return calib::combined(s, calib::header_setting(frame));
}

// What the user should know of how a setting came about.
std::vector<std::string> notes_on(const calib::SpotSetting& setting, const fs::path& frame,
                                  const std::optional<calib::SettingTable>& table) {
  std::vector<std::string> out;
  if (table && !table->find(frame))
    out.push_back("has no line in " + utf8_text(table->name()) + "; its header is taken");
  if (const auto doubt = calib::doubt_of_kind(setting)) out.push_back(*doubt);
  return out;
}

void run(const Options& o, const Invocation& invocation) {
  o.output.check();
  check_mount(o.mount);
  require_distinct(o.frames, o.darks);
  o.output.keep({o.frames.begin(), o.frames.end()});
  o.output.keep({o.darks.begin(), o.darks.end()});
  const fs::path csv = o.output.targets.front();
  const calib::SpotSetting command_line = command_line_setting(o);
  std::optional<calib::SettingTable> table;
  if (!o.angles.empty()) table = calib::SettingTable::read(o.angles);
  if (table) table->require_one_frame_each(o.frames);
  SpotFinder finder(o);
  calib::TargetList list;
  std::vector<MeasuredFrame> measured;
  const Progress progress = progress_bar("spots");
  for (std::size_t i = 0; i < o.frames.size(); ++i) {
    if (progress) progress(o.frames[i], static_cast<double>(i) / static_cast<double>(o.frames.size()));
    const Frame frame = read_frame(o.frames[i]);
    const calib::SpotSetting setting = setting_of(frame, command_line, table);
    calib::Target target = calib::target_of(setting, frame.file);
    target.file = path_beside(frame.file, csv);
    if (target.kind == calib::TargetKind::kSpecular) {
      const std::string mount = setting.mount.value_or("");
      const auto known = std::find(list.mounts.begin(), list.mounts.end(), mount);
      target.mount = static_cast<std::size_t>(known - list.mounts.begin());
      if (known == list.mounts.end()) list.mounts.push_back(mount);
    }
    measured.push_back({frame.file, finder.find(frame), notes_on(setting, frame.file, table)});
    if (measured.back().found.spots.empty()) continue;
    const calib::Spot& spot = measured.back().found.spots.front();
    target.column_px = spot.column_px;
    target.row_px = spot.row_px;
    target.sigma_px = spot.sigma_px();
    list.targets.push_back(target);
  }
  require_some_spot(measured);
  const std::string text = header_lines(o, invocation) + calib::to_csv(list);
  calib::parse_targets(text, csv.string());  // a mount or an angle that calibrate would refuse
  write_text_file(csv, text, o.output.overwrite());
  print_notes(measured);
  o.output.json ? print_json(measured, o.method) : print_text(measured);
}

}  // namespace

void setup_spots(CLI::App& app, const Invocation& invocation) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("spots", "centroids of specular spots in raw frames, with their uncertainty");
  verb->add_option("frames", o->frames, "raw frames, one target each")->required();
  verb->add_option("--darks", o->darks, "dark frames of the same exposure; none: each frame's own background");
  verb->add_option("--instrument", o->instrument, "instrument.toml, for gain, read noise and saturation");
  verb->add_option("--gain-e-per-dn", o->gain_e_per_dn, "instead of the instrument's")->check(positive_number());
  verb->add_option("--read-noise-e", o->read_noise_e, "instead of the instrument's")->check(non_negative_number());
  verb->add_option("--saturation-dn", o->saturation_dn, "instead of the instrument's")->check(positive_number());
  verb->add_option(
      "--angles", o->angles,
      "CSV with the column file and any of kind, stage_deg, arm_deg, tilt_deg, mount; overrides FITS headers");
  verb->add_option("--stage-deg", o->stage_deg, "of a single frame; overrides the rest")->check(angle_range());
  verb->add_option("--arm-deg", o->arm_deg, "of a single frame")->check(angle_range());
  verb->add_option("--tilt-deg", o->tilt_deg, "known mirror tilt of a single frame")
      ->check(CLI::Range(-89.0, 89.0) & finite_number());
  verb->add_option("--kind", o->kind, "of a single frame; without it the header's TARGET, else specular")
      ->check(CLI::IsMember({"specular", "direct"}));
  verb->add_option("--mount", o->mount, "mirror mounting of a single frame");
  verb->add_option("--method", o->method, "ml: Gaussian maximum likelihood; moments: windowed moments")
      ->check(CLI::IsMember({"ml", "moments"}))
      ->capture_default_str();
  o->output.add_to(*verb, "targets.csv", {".csv"});
  verb->callback([o, invocation] { run(*o, invocation); });
}

}  // namespace scatmap::tools
