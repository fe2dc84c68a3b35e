#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>

#include <nlohmann/json.hpp>

#include "scatmap/angles/instrument.h"
#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/provenance.h"
#include "scatmap/counts/dark.h"
#include "scatmap/counts/photon_transfer.h"
#include "tools/output_options.h"
#include "tools/toml_comment.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

struct Options {
  std::vector<std::string> flats, darks;
  std::string instrument;
  std::optional<double> saturation_dn;
  OutputOptions output;
};

using FramesByTime = std::map<double, std::vector<Frame>>;

void check_size(const Frame& f, const Instrument& instrument, const std::string& instrument_file) {
  if (f.dn.columns() == instrument.columns && f.dn.rows() == instrument.rows) return;
  throw Error({f.file.string(), "has the wrong size",
               std::to_string(f.dn.columns()) + " x " + std::to_string(f.dn.rows()),
               std::to_string(instrument.columns) + " x " + std::to_string(instrument.rows) +
                   " as detector.columns and rows of " + instrument_file + " say"});
}

FramesByTime read_by_time(const std::vector<std::string>& files, const Instrument& instrument,
                          const std::string& instrument_file, std::vector<InputRecord>& records) {
  FramesByTime out;
  for (const std::string& file : files) {
    Frame f = read_frame(file);
    check_size(f, instrument, instrument_file);
    if (!f.header.exposure_s) throw Error({file, "does not say its exposure time", {}, "EXPTIME"});
    records.push_back(record_input(file, f.state));
    out[*f.header.exposure_s].push_back(std::move(f));
  }
  return out;
}

std::vector<TransferLevel> levels_of(const FramesByTime& flats, const FramesByTime& darks) {
  std::vector<TransferLevel> out;
  for (const auto& [time, frames] : flats) {
    const auto dark = darks.find(time);
    if (dark == darks.end()) {
      throw Error({frames.front().file.string(), "has no dark of its exposure time", std::to_string(time) + " s",
                   "two or more among --darks"});
    }
    out.push_back({time, frames, dark->second});
  }
  return out;
}

// What all frames say of their gain; nullopt if they say nothing. @throws Error if they say different things
std::optional<double> header_gain(const FramesByTime& flats) {
  const Frame& first = flats.begin()->second.front();
  for (const auto& [time, frames] : flats) {
    for (const Frame& f : frames) {
      if (f.header.gain_e_per_dn == first.header.gain_e_per_dn) continue;
      const auto text = [](const Frame& of) {
        return of.header.gain_e_per_dn ? number_text(*of.header.gain_e_per_dn) : std::string("nothing");
      };
      throw Error({f.file.string() + ": EGAIN", "differs from that of " + first.file.string(), text(f), text(first)});
    }
  }
  return first.header.gain_e_per_dn;
}

Instrument with_sensor(Instrument instrument, const PhotonTransfer& p) {
  Sensor& s = instrument.sensor;
  s.gain_e_per_dn = 1 / p.gain_dn_per_e.value;
  s.read_noise_e = p.dark_noise_e.value;
  s.bias_dn = p.bias_dn.value;
  if (p.saturation_dn) s.saturation_dn = *p.saturation_dn;
  s.linearity = p.linearity;
  if (p.nonlinearity_left) s.nonlinearity_percent = 100 * *p.nonlinearity_left;
  return instrument;
}

// Variance against mean is a straight line, or frames are not what their headers say.
constexpr double kDoubtfulChiSquared = 10, kImpossibleChiSquared = 1000;
void require_one_line(const PhotonTransfer& p) {
  if (p.chi_squared <= kImpossibleChiSquared) return;
  throw Error({"flats", "do not lie on one photon transfer line: do their headers tell the true exposure times?",
               "chi-squared " + number_text(std::round(p.chi_squared)), "about 1"});
}

void print_json(const PhotonTransfer& p) {
  const auto estimate = [](const Estimate& e) { return nlohmann::json{{"value", e.value}, {"u", e.u}}; };
  nlohmann::json out{{"gain_dn_per_e", estimate(p.gain_dn_per_e)},
                     {"dark_noise_e", estimate(p.dark_noise_e)},
                     {"bias_dn", estimate(p.bias_dn)},
                     {"dsnu_e", estimate(p.dsnu_e)},
                     {"prnu", estimate(p.prnu)},
                     {"chi_squared", p.chi_squared}};
  out["saturation_dn"] = p.saturation_dn ? nlohmann::json(*p.saturation_dn) : nlohmann::json(nullptr);
  out["dark_current_e_per_s"] = estimate(p.dark_current_e_per_s);
  out["left_out_pixels"] = p.left_out_pixels;
  if (p.linearity_error) out["linearity_error"] = estimate(*p.linearity_error);
  if (p.largest_deviation) out["largest_deviation"] = *p.largest_deviation;
  out["linearity"] = p.linearity;
  if (p.nonlinearity_left) out["nonlinearity_left"] = *p.nonlinearity_left;
  for (const TransferPoint& t : p.points) {
    out["points"].push_back({{"exposure_s", t.exposure_s},
                             {"mean_dn", t.mean_dn},
                             {"variance_dn2", t.variance_dn2},
                             {"dark_mean_dn", t.dark_mean_dn},
                             {"dark_variance_dn2", t.dark_variance_dn2},
                             {"used", t.used}});
  }
  std::printf("%s\n", out.dump(2).c_str());
}

void print_text(const PhotonTransfer& p) {
  std::printf("%10s %12s %14s %12s %14s %s\n", "exposure", "mean DN", "variance DN^2", "dark DN", "variance DN^2",
              "in the gain's fit");
  for (const TransferPoint& t : p.points) {
    std::printf("%8.4g s %12.2f %14.2f %12.2f %14.2f %s\n", t.exposure_s, t.mean_dn, t.variance_dn2, t.dark_mean_dn,
                t.dark_variance_dn2, t.used ? "yes" : "no");
  }
  const double gain = 1 / p.gain_dn_per_e.value;
  std::printf("gain K          %.5g DN/e, u %.2g (%.5g e/DN); chi-squared %.2f\n", p.gain_dn_per_e.value,
              p.gain_dn_per_e.u, gain, p.chi_squared);
  std::printf("dark noise      %.3f e, u %.2g\n", p.dark_noise_e.value, p.dark_noise_e.u);
  std::printf("dark current    %.4g e/s, u %.2g\n", p.dark_current_e_per_s.value, p.dark_current_e_per_s.u);
  std::printf("bias            %.2f DN, u %.2g\n", p.bias_dn.value, p.bias_dn.u);
  if (p.saturation_dn) std::printf("saturation      %.1f DN\n", *p.saturation_dn);
  if (!p.saturation_dn) std::printf("saturation      not reached: the variance still grows at the longest exposure\n");
  std::printf("DSNU            %.3f e, u %.2g\n", p.dsnu_e.value, p.dsnu_e.u);
  std::printf("PRNU            %.3f %%, u %.2g\n", 100 * p.prnu.value, 100 * p.prnu.u);
  if (p.linearity_error) {
    std::printf("linearity error %.3f %% on average, u %.2g, largest %.3f %%\n", 100 * p.linearity_error->value,
                100 * p.linearity_error->u, 100 * *p.largest_deviation);
  }
  if (p.nonlinearity_left) {
    std::printf("correction      %zu coefficients; no two levels differ by more than %.3f %% after it\n",
                p.linearity.size(), 100 * *p.nonlinearity_left);
  }
}

void run(const Options& o, const Invocation& invocation) {
  o.output.check();
  require_distinct(o.flats, o.darks);
  o.output.keep({o.flats.begin(), o.flats.end()});
  o.output.keep({o.darks.begin(), o.darks.end()});
  Provenance provenance{invocation.command_line, "scatmap " + version(), {record_input(o.instrument)}};
  const Instrument nominal = read_instrument(o.instrument);
  const FramesByTime flats = read_by_time(o.flats, nominal, o.instrument, provenance.inputs),
                     darks = read_by_time(o.darks, nominal, o.instrument, provenance.inputs);
  for (const auto& [time, frames] : darks) std::for_each(frames.begin(), frames.end(), require_dark);
  const std::vector<TransferLevel> levels = levels_of(flats, darks);
  const PhotonTransfer p = photon_transfer(levels, nominal.sensor.saturation_dn, o.saturation_dn);
  require_one_line(p);
  Instrument measured = with_sensor(nominal, p);
  measured.sensor.header_gain_e_per_dn = header_gain(flats);
  write_text_file(o.output.targets.front(),
                  "# The sensor's table is measured by photon transfer (EMVA 1288).\n" + toml_comment(provenance) +
                      to_toml(measured),
                  o.output.overwrite());
  o.output.json ? print_json(p) : print_text(p);
  std::fflush(stdout);
  if (p.left_out_pixels > 0)
    std::fprintf(stderr, "note: %zu defective pixels are left out: their darks stand far off at any exposure\n",
                 p.left_out_pixels);
  if (!(p.chi_squared <= kDoubtfulChiSquared))
    std::fprintf(stderr, "note: chi-squared %.1f where 1 is expected: some flat is not what its header says\n",
                 p.chi_squared);
  if (p.nonlinearity_left) return;
  std::fprintf(stderr,
               "note: too few levels for the linearity: nonlinearity_percent stays at %s as in %s, not measured\n",
               number_text(nominal.sensor.nonlinearity_percent).c_str(), o.instrument.c_str());
}

}  // namespace

void setup_sensor(CLI::App& app, const Invocation& invocation) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand(
      "sensor", "gain, noise, saturation and linearity of the sensor from flats and darks (EMVA 1288)");
  verb->add_option("flats", o->flats, "frames under constant uniform light: two or more per exposure time")->required();
  verb->add_option("--darks", o->darks, "dark frames: two or more per exposure time of the flats")->required();
  verb->add_option("--instrument", o->instrument, "instrument.toml whose [sensor] is to be replaced")->required();
  verb->add_option("--saturation-dn", o->saturation_dn, "instead of what the frames and the instrument say")
      ->check(positive_number());
  o->output.add_to(*verb, "instrument.toml to write", {".toml"});
  verb->callback([o, invocation] { run(*o, invocation); });
}

}  // namespace scatmap::tools
