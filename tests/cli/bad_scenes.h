#pragma once
#include "cli/bad_input.h"

namespace scatmap::test {

/// scene.toml and the folder to write, of `simulate`.
inline std::vector<BadInput> bad_scenes() {
  const std::string file = "scene.toml";
  const std::vector<std::string> run{"simulate", file, "-o", "out"};
  const std::vector<std::string> forced{"simulate", file, "-o", "out", "--force"};
  const auto edited = [&](const char* name, const std::string& from, const std::string& to,
                          std::vector<std::string> says) {
    return BadInput{name, run, replace(file, from, to), 1, std::move(says)};
  };
  const auto unknown = [&](const std::string& table) { return replace(file, table, table + "\nsurprise = 1"); };
  const std::string here = file + ":%: ";
  return {
      {"scene: no such file", run, erase(file), 1, {file, "no such file"}},
      {"scene: empty file", run, write(file, ""), 1, {file, "kind"}},
      {"scene: a folder", run, all({erase(file), make_folder(file)}), 1, {file}},
      edited("scene: syntax", "seed = 20", "seed = 20 20", {file + ":%"}),
      edited("scene: unknown kind", "kind = \"brdf\"", "kind = \"brrdf\"", {here + "kind", "brrdf"}),
      edited("scene: seed negative", "seed = 20", "seed = -20", {here + "seed"}),
      edited("scene: seed no integer", "seed = 20", "seed = 20.5", {here + "seed"}),
      edited("scene: wavelength NaN", "wavelength_nm = 512.0", "wavelength_nm = nan", {here + "wavelength_nm"}),
      edited("scene: stage missing", "stage_deg = 20.0", "", {file, "stage_deg", "missing"}),
      edited("scene: stage beyond a turn", "stage_deg = 20.0", "stage_deg = 1e9", {here + "stage_deg"}),
      edited("scene: stage at grazing incidence", "stage_deg = 20.0", "stage_deg = 90.0", {file, "stage_deg"}),
      edited("scene: distance missing", "distance_mm = 325.0", "", {file, "detector.distance_mm", "missing"}),
      edited("scene: distance zero", "distance_mm = 325.0", "distance_mm = 0.0", {here + "detector.distance_mm"}),
      edited("scene: no rows", "rows = 64", "rows = 0", {here + "detector.rows"}),
      edited("scene: pitch negative", "[212.5, 212.5]", "[-212.5, 212.5]", {here + "detector.pitch_um"}),
      edited("scene: gain missing", "gain_e_per_dn = 1.5", "", {file, "sensor.gain_e_per_dn", "missing"}),
      edited("scene: saturation below the bias", "saturation_dn = 65535.0", "saturation_dn = 299.0",
             {here + "sensor.saturation_dn"}),
      edited("scene: laser missing", "[laser]", "[lasr]", {file, "laser", "missing"}),
      edited("scene: unknown filter", "[\"nd30\"]", "[\"nd31\"]", {here + "exposure.0.filters", "nd31"}),
      edited("scene: filter twice", "[\"nd30\"]", "[\"nd30\", \"nd30\"]", {here + "exposure.0.filters", "nd30"}),
      edited("scene: filter without uncertainty", "tolerance_od = 0.125", "", {file, "filters.nd30"}),
      edited("scene: filter with two uncertainties", "tolerance_od = 0.125", "tolerance_od = 0.125\nu_od = 0.1",
             {file, "filters.nd30"}),
      edited("scene: no frame", "frames = 2\n", "frames = 0\n#", {file, "signature.frames"}),
      edited("scene: exposure zero", "exposure_s = 0.25", "exposure_s = 0.0", {here + "exposure.0.exposure_s"}),
      edited("scene: no exposure", "[[exposure]]", "[elsewhere]", {file, "exposure", "missing"}),
      edited("scene: unknown term", "\"microfacet\"", "\"phong\"", {here + "term.0.kind", "phong"}),
      {"scene: unknown key at the top", run, unknown("seed = 20"), 1, {here + "surprise", "not a known key"}},
      {"scene: unknown key in detector",
       run,
       unknown("[detector]"),
       1,
       {here + "detector.surprise", "not a known key"}},
      {"scene: unknown key in sensor", run, unknown("[sensor]"), 1, {here + "sensor.surprise", "not a known key"}},
      {"scene: unknown key in laser", run, unknown("[laser]"), 1, {here + "laser.surprise", "not a known key"}},
      {"scene: unknown key in a filter",
       run,
       unknown("[filters.nd30]"),
       1,
       {here + "filters.nd30.surprise", "not a known key"}},
      {"scene: unknown key in signature",
       run,
       unknown("[signature]"),
       1,
       {here + "signature.surprise", "not a known key"}},
      {"scene: unknown key in exposure",
       run,
       unknown("[[exposure]]"),
       1,
       {here + "exposure.0.surprise", "not a known key"}},
      {"scene: unknown key in a term", run, unknown("[[term]]"), 1, {here + "term.0.surprise", "not a known key"}},
      {"simulate: into a file", forced, write("out", "mine"), 1, {"out", "not a folder"}},
      {"simulate: into a used folder",
       run,
       all({make_folder("out"), write("out/notes.txt", "mine")}),
       1,
       {"out", "--force"}},
      {"simulate: over a folder not its own",
       forced,
       all({make_folder("out"), write("out/notes.txt", "mine")}),
       1,
       {"out", "not ours"}},
      {"simulate: into a missing folder", {"simulate", file, "-o", "nowhere/out"}, nothing(), 1, {"nowhere/out"}},
      {"simulate: into a folder that is a file",
       {"simulate", file, "-o", "scene.toml/out"},
       nothing(),
       1,
       {"scene.toml/out"}},
  };
}

}  // namespace scatmap::test
