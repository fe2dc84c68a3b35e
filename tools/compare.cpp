#include <algorithm>
#include <cstdio>
#include <memory>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/output_folder.h"
#include "scatmap/base/units.h"
#include "scatmap/report/comparison_text.h"
#include "scatmap/report/map_fits.h"
#include "scatmap/report/picture.h"
#include "tools/output_options.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string measured;
  std::string modelled;
  std::string pictures = "png";
  bool keep_scripts = false;
  bool other_directions = false;
  OutputOptions output;
};

std::string case_title(const BrdfMap& map) {
  char text[64];
  std::snprintf(text, sizeof text, "theta_i = %.1f deg", map.angles.theta_i_rad * kDegPerRad);
  return text;
}

std::string peak_title(std::size_t index, const Peak& peak) {
  char text[96];
  std::snprintf(text, sizeof text, "pixel column through peak %zu (column %.0f)", index + 1, peak.column_px);
  return text;
}

void draw(const Comparison& c, const BrdfMap& measured, const BrdfMap& modelled, const fs::path& folder,
          const Options& o) {
  const PictureOptions options{Overwrite::kKeep, o.keep_scripts};
  const auto name = [&](const char* stem) { return folder / (stem + ("." + o.pictures)); };
  const std::vector<MapPanel> maps{{&measured, "measured, " + case_title(measured)},
                                   {&modelled, "modelled, " + case_title(modelled)}};
  draw_map(maps, name("maps"), options);
  std::vector<ProfilePanel> profiles;
  for (std::size_t i = 0; i < c.columns.size(); ++i)
    profiles.push_back({&c.columns[i].measured, &c.columns[i].modelled, peak_title(i, c.measured.peaks[i])});
  if (!profiles.empty()) draw_overview(maps, profiles, name("overview"), options);
  if (c.ridge)
    draw_profiles({{&c.ridge->measured, &c.ridge->modelled, "along the fringe band"}}, name("fringes"), options);
  if (c.residual)
    draw_residual(*c.residual, measured, "(measured - modelled) / u, " + case_title(measured), name("residual"),
                  options);
}

// A calibrated bench and its nominal one agree within this or their pixels do not belong together.
constexpr double kSameDirection_px = 1;

Comparison compared(const BrdfMap& measured, const BrdfMap& modelled, const Options& o) try {
  const auto& f = modelled.brdf_per_sr;
  if (std::none_of(f.begin(), f.end(), [](double value) { return value > 0; }))
    throw Error({{}, "the model is 0 at every pixel: there is no scale to compare", {}, {}});
  Comparison c = compare(measured, modelled);
  const double off_px = c.direction_difference_px;
  if (!(off_px <= kSameDirection_px) && !o.other_directions) {
    throw Error({{},
                 "the maps look elsewhere: their pixels' directions differ",
                 "up to " + number_text(off_px) + " px",
                 "at most " + number_text(kSameDirection_px) + " px, or --other-directions to compare pixel by pixel"});
  }
  return c;
} catch (const Error& e) {
  throw with_context(o.measured + " against " + o.modelled, e);
}

void run(const Options& o, const Invocation& invocation) {
  OutputFolder folder(o.output.targets.front(), "comparison.json", o.output.overwrite());
  const BrdfMap measured = read_map_fits(o.measured), modelled = read_map_fits(o.modelled);
  if (measured.u_random_per_sr.empty())
    throw Error({o.measured, "is a modelled map: it has no uncertainties", {}, "the measured map first"});
  if (!modelled.u_random_per_sr.empty())  // its noise would count as the model's, and pull a free scale towards 0
    throw Error({o.modelled, "is a measured map", {}, "the modelled map second"});
  const Provenance provenance{
      invocation.command_line, "scatmap " + version(), {record_input(o.measured), record_input(o.modelled)}};
  const Comparison c = compared(measured, modelled, o);
  const std::string json = comparison_json(c, provenance), text = comparison_text(c);
  write_text_file(folder.temporary() / "comparison.json", json, Overwrite::kKeep);
  write_residual_fits(c, measured, provenance, folder.temporary() / "residual.fits", Overwrite::kKeep);
  if (o.pictures != "none") draw(c, measured, modelled, folder.temporary(), o);
  folder.commit();
  std::printf("%s", o.output.json ? json.c_str() : text.c_str());
  if (!(c.direction_difference_px <= kSameDirection_px)) {
    std::fflush(stdout);
    std::fprintf(stderr, "note: the maps look elsewhere: directions differ by up to %.4g px\n",
                 c.direction_difference_px);
  }
}

}  // namespace

void setup_compare(CLI::App& app, const Invocation& invocation) {
  auto o = std::make_shared<Options>();
  CLI::App* verb =
      app.add_subcommand("compare", "a measured map against a modelled one: residuals, peaks, fringes, pictures");
  verb->add_option("measured", o->measured, "measured map (FITS)")->required();
  verb->add_option("modelled", o->modelled, "modelled map (FITS)")->required();
  verb->add_option("--pictures", o->pictures, "picture format")
      ->check(CLI::IsMember({"png", "svg", "none"}))
      ->capture_default_str();
  verb->add_flag("--keep-scripts", o->keep_scripts, "leave gnuplot script and data beside each picture");
  verb->add_flag("--other-directions", o->other_directions,
                 "compare pixel by pixel even where the maps' directions differ by more than a pixel");
  o->output.add_to(*verb, "folder to make: comparison.json, residual.fits, pictures", {});
  verb->callback([o, invocation] { run(*o, invocation); });
}

}  // namespace scatmap::tools
