#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/units.h"
#include "scatmap/compare/model_map.h"
#include "scatmap/model/model_toml.h"
#include "scatmap/report/map_exr.h"
#include "scatmap/report/map_fits.h"
#include "tools/output_options.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

struct Options {
  std::string model;
  std::string like;
  std::string precision = "single";
  OutputOptions output;
};

void run(const Options& o, const Invocation& invocation) {
  o.output.check();
  const Model model = read_model(o.model);
  const MapView view = read_map_view(o.like);
  const std::vector<InputRecord> inputs{record_input(o.model), record_input(o.like)};
  constexpr double kSameWavelength = 1e-6;
  if (view.wavelength_m > 0 && !(std::abs(model.wavelength_m / view.wavelength_m - 1) <= kSameWavelength)) {
    throw Error({o.model + ": wavelength_nm", "differs from that of " + o.like,
                 number_text(model.wavelength_m / kMetrePerNm), number_text(view.wavelength_m / kMetrePerNm)});
  }
  BrdfMap map = model_map(model, view.instrument, view.pose);
  map.provenance = {invocation.command_line, "scatmap " + version(), inputs};
  for (const std::string& target : o.output.targets) {
    if (extension_of(target) == ".exr") {
      write_map_exr(map, target, o.output.overwrite());
    } else {
      write_map_fits(map, target, o.precision == "double" ? Precision::kDouble : Precision::kSingle,
                     o.output.overwrite());
    }
  }
  double largest = -HUGE_VAL;
  for (const double f : map.brdf_per_sr) {
    if (f > largest) largest = f;
  }
  if (o.output.json) {
    const nlohmann::json out{{"theta_i_deg", map.angles.theta_i_rad * kDegPerRad},
                             {"largest_per_sr", largest},
                             {"terms", model.terms.size()},
                             {"method", "exact"}};
    std::printf("%s\n", out.dump(2).c_str());
  } else {
    std::printf("%zu terms at theta_i %.4f deg, largest BRDF %.4g sr^-1\n", model.terms.size(),
                map.angles.theta_i_rad * kDegPerRad, largest);
  }
}

}  // namespace

void setup_model(CLI::App& app, const Invocation& invocation) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("model", "a closed-form BRDF model on the pixel directions of a map");
  verb->add_option("model", o->model, "model.toml")->required();
  verb->add_option("--like", o->like, "map or angle file whose instrument and pose give the directions")->required();
  verb->add_option("--precision", o->precision, "of BRDF in FITS; angles are always double")
      ->check(CLI::IsMember({"single", "double"}))
      ->capture_default_str();
  o->output.add_to(*verb, "OUT.fits or OUT.exr; give -o twice for both", {".fits", ".fit", ".exr"});
  verb->callback([o, invocation] { run(*o, invocation); });
}

}  // namespace scatmap::tools
