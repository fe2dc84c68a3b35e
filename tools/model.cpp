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
  std::string method;
  double tolerance_rel = kDefaultModelTolerance;
  bool pixel_average = false;
  OutputOptions output;
};

// 1e-15 to 0.1, and not NaN, which CLI::Range lets through.
CLI::Validator tolerance_range() {
  return {[](std::string& text) {
            double value = 0;
            if (CLI::detail::lexical_cast(text, value) && value >= 1e-15 && value <= 0.1) return std::string();
            return "Value " + text + " not in range 1e-15 to 0.1";
          },
          "in [1e-15, 0.1]"};
}

FrameModelOptions evaluation(const Options& o) {
  const auto named = model_method_of(o.method);
  const ModelMethod method = named ? *named : choose_model_method(o.tolerance_rel);
  if ((method == ModelMethod::kCulled || o.pixel_average) && o.tolerance_rel < kSmallestCulledTolerance) {
    throw Error({"--tolerance-rel", "is finer than tiles keep", number_text(o.tolerance_rel),
                 number_text(kSmallestCulledTolerance) + " or more, or --method exact"});
  }
  return {method, o.tolerance_rel, o.pixel_average};
}

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const MethodBound& row : model_method_bounds()) names.emplace_back(row.method);
  return names;
}

// How the model was evaluated; errors are relative.
struct Evaluated {
  const char* method;
  double bound;
  double rounding;  // of the directions, whatever the method
};

void print(const Options& o, const Model& model, const BrdfMap& map, const Evaluated& done) {
  double largest = -HUGE_VAL;
  for (const double f : map.brdf_per_sr) {
    if (f > largest) largest = f;
  }
  if (largest == 0)
    std::fprintf(stderr,
                 "note: the model is 0 at every pixel: a lobe that falls between pixel centres shows with "
                 "--pixel-average\n");
  if (o.output.json) {
    const nlohmann::json out{{"theta_i_deg", map.angles.theta_i_rad * kDegPerRad},
                             {"largest_per_sr", largest},
                             {"terms", model.terms.size()},
                             {"method", done.method},
                             {"bound_rel", done.bound},
                             {"rounding_rel", done.rounding}};
    std::printf("%s\n", out.dump(2).c_str());
  } else {
    std::printf("%zu terms at theta_i %.4f deg, largest BRDF %.4g sr^-1\n", model.terms.size(),
                map.angles.theta_i_rad * kDegPerRad, largest);
    std::printf("method %s, bound %.2e relative; rounding of directions adds %.2e\n", done.method, done.bound,
                done.rounding);
  }
}

void run(const Options& o, const Invocation& invocation) {
  o.output.check();
  o.output.keep({o.model, o.like});
  const Model model = read_model(o.model);
  const MapView view = read_map_view(o.like);
  const std::vector<InputRecord> inputs{record_input(o.model), record_input(o.like)};
  constexpr double kSameWavelength = 1e-6;
  if (view.wavelength_m > 0 && !(std::abs(model.wavelength_m / view.wavelength_m - 1) <= kSameWavelength)) {
    throw Error({o.model + ": wavelength_nm", "differs from that of " + o.like,
                 number_text(model.wavelength_m / kMetrePerNm), number_text(view.wavelength_m / kMetrePerNm)});
  }
  const FrameModelOptions options = evaluation(o);
  BrdfMap map = model_map(model, view.instrument, view.pose, options);
  map.provenance = {invocation.command_line, "scatmap " + version(), inputs};
  for (const std::string& target : o.output.targets) {
    if (extension_of(target) == ".exr") {
      write_map_exr(map, target, o.output.overwrite());
    } else {
      write_map_fits(map, target, o.precision == "double" ? Precision::kDouble : Precision::kSingle,
                     o.output.overwrite());
    }
  }
  const char* const method = o.pixel_average ? "pixel-average" : model_method_name(options.method);
  const double bound = model_error_bound(options);
  const double rounding =
      model_rounding_error(model, sample_view(view.instrument, view.pose).to_source, view.instrument.geometry.distance);
  if (o.method.empty() && !(bound <= o.tolerance_rel))
    std::fprintf(stderr, "note: no method meets %s relative: %s, bound %.2e\n", number_text(o.tolerance_rel).c_str(),
                 method, bound);
  print(o, model, map, {method, bound, rounding});
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
  verb->add_option("--tolerance-rel", o->tolerance_rel,
                   "error allowed, relative to the larger of the value and 1e-6 of the largest; the cheapest "
                   "method within it is taken")
      ->check(tolerance_range())
      ->capture_default_str();
  CLI::Option* const method = verb->add_option("--method", o->method, "a method by name, whatever its error")
                                  ->check(CLI::IsMember(method_names()));
  verb->add_flag("--pixel-average", o->pixel_average,
                 "means over the pixels within the tolerance, not values at centres")
      ->excludes(method);
  o->output.add_to(*verb, "OUT.fits or OUT.exr; give -o twice for both", {".fits", ".fit", ".exr"});
  verb->callback([o, invocation] { run(*o, invocation); });
}

}  // namespace scatmap::tools
