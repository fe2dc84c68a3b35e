#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "scatmap/angles/angle_map.h"
#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "scatmap/report/map_exr.h"
#include "scatmap/report/map_fits.h"
#include "tools/output_options.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

struct Options {
  std::string instrument;
  double stage_deg = 0;
  double arm_deg = 0;
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

void print(const AngleMap& map, bool json) {
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
                       {"method", "exact"},
                       {"bound_rad", kAngleMaxError_rad}};
    std::printf("%s\n", out.dump(2).c_str());
    return;
  }
  std::printf("theta_i %.6f deg, %zu of %zu pixels see the sample's front\n", map.theta_i_rad * kDegPerRad, good,
              map.mask.size());
  if (good > 0)
    std::printf("theta_s %.6f to %.6f deg, phi_s %.6f to %.6f deg\n", theta.low, theta.high, phi.low, phi.high);
}

AngleMap angles_of(const Instrument& instrument, const Pose& pose, const std::string& file) try {
  return angle_map(instrument, pose);
} catch (const Error& e) {
  throw with_context(file, e);
}

void run(const Options& o, const Invocation& invocation) {
  o.output.check();
  const Instrument instrument = read_instrument(o.instrument);
  const Provenance provenance{invocation.command_line, "scatmap " + version(), {record_input(o.instrument)}};
  const Pose pose{o.stage_deg * kRadPerDeg, o.arm_deg * kRadPerDeg};
  const AngleMap map = angles_of(instrument, pose, o.instrument);
  for (const std::string& target : o.output.targets) {
    if (extension_of(target) == ".exr") {
      write_angles_exr(map, provenance, target, o.output.overwrite());
    } else {
      write_angles_fits(map, instrument, pose, provenance, target, o.output.overwrite());
    }
  }
  print(map, o.output.json);
}

}  // namespace

void setup_angles(CLI::App& app, const Invocation& invocation) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("angles", "per-pixel scatter angles and solid angles of an instrument at a pose");
  verb->add_option("instrument", o->instrument, "instrument.toml")->required();
  verb->add_option("--stage-deg", o->stage_deg, "commanded stage angle")->required()->check(angle_range());
  verb->add_option("--arm-deg", o->arm_deg, "commanded arm angle")->required()->check(angle_range());
  o->output.add_to(*verb, "OUT.fits or OUT.exr; give -o twice for both", {".fits", ".fit", ".exr"});
  verb->callback([o, invocation] { run(*o, invocation); });
}

}  // namespace scatmap::tools
