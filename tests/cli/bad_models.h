#pragma once
#include "cli/bad_input.h"

namespace scatmap::test {

/// model.toml and the map of --like, read by `model`.
inline std::vector<BadInput> bad_models() {
  const std::string file = "model.toml", map = "maps/measured.fits";
  const std::vector<std::string> run{"model", file, "--like", map, "-o", "out.fits"};
  const auto edited = [&](const char* name, const std::string& from, const std::string& to,
                          std::vector<std::string> says) {
    return BadInput{name, run, replace(file, from, to), 1, std::move(says)};
  };
  const std::string here = file + ":%: ";
  return {
      {"model: no such file", run, erase(file), 1, {file, "no such file"}},
      {"model: empty file", run, write(file, ""), 1, {file, "wavelength_nm"}},
      edited("model: syntax", "[[term]]", "[[term]", {file + ":%"}),
      {"model: no term", run, write(file, "wavelength_nm = 512\n"), 1, {file, "term", "missing"}},
      edited("model: term without kind", "kind = \"microfacet\"", "", {file, "term.0.kind", "missing"}),
      edited("model: unknown kind", "\"microfacet\"", "\"phong\"", {here + "term.0.kind", "phong"}),
      edited("model: m negative", "m = 0.0078125", "m = -0.0078125", {here + "term.0.m"}),
      edited("model: m zero", "m = 0.0078125", "m = 0", {here + "term.0.m"}),
      edited("model: m NaN", "m = 0.0078125", "m = nan", {here + "term.0.m"}),
      edited("model: m missing", "m = 0.0078125", "", {file, "term.0.m", "missing"}),
      edited("model: rho negative", "rho = 0.5", "rho = -0.5", {here + "term.0.rho"}),
      edited("model: n missing", "n = [1.5, 0.25]", "", {file, "term.0.n", "missing"}),
      edited("model: n of one number", "n = [1.5, 0.25]", "n = [1.5]", {here + "term.0.n"}),
      edited("model: n a number", "n = [1.5, 0.25]", "n = 1.5", {here + "term.0.n"}),
      edited("model: n of nothing", "n = [1.5, 0.25]", "n = [0, 0.25]", {here + "term.0.n"}),
      edited("model: n and n_file", "n = [1.5, 0.25]", "n_file = \"gold.yml\"\nn = [1.5, 0.25]",
             {here + "term.0.n", "n_file"}),
      edited("model: n_file missing", "n = [1.5, 0.25]", "n_file = \"gold.yml\"", {"gold.yml", "no such file"}),
      edited("model: facet tilted away", "n = [1.5, 0.25]", "n = [1.5, 0.25]\ndtheta_deg = 91 #",
             {here + "term.0.dtheta_deg"}),
      edited("model: stripes of no width", "b_um = 10", "b_um = 0", {here + "term.1.b_um"}),
      edited("model: unknown form", "form = \"grating\"", "form = \"lattice\"", {here + "term.1.form", "lattice"}),
      edited("model: unknown polarisation", "polarization = \"s\"", "polarization = \"circular\"",
             {here + "polarization", "circular"}),
      edited("model: wavelength missing", "wavelength_nm = 512", "", {file, "wavelength_nm", "missing"}),
      edited("model: wavelength not the map's", "wavelength_nm = 512", "wavelength_nm = 513",
             {file, "wavelength_nm", map}),
      edited("model: phi_ref beyond a turn", "phi_ref_deg = 0", "phi_ref_deg = 361", {here + "phi_ref_deg"}),
      edited("model: unknown key at the top", "phi_ref_deg = 0", "phi_ref_deg = 0\nscale = 2",
             {here + "scale", "not a known key"}),
      edited("model: unknown key in a term", "rho = 0.5", "rho = 0.5\nsigma = 2",
             {here + "term.0.sigma", "not a known key"}),
      edited("model: another term's key", "rho = 0.5", "rho = 0.5\na_um = 2",
             {here + "term.0.a_um", "not a known key"}),
      {"like: no such file", run, erase(map), 1, {map, "exist"}},
      {"like: empty file", run, write(map, ""), 1, {map}},
      {"like: text", run, copy("model.toml", map), 1, {map, "FITS"}},
      {"like: raw frame", run, all({erase(map), copy("frames/exposure1_001.fits", map)}), 1, {map, "no map"}},
      {"like: a folder", run, all({erase(map), make_folder(map)}), 1, {map, "folder"}},
      {"like: unreadable", run, unreadable(map), 1, {map, "read"}, true},
      {"like: gzip", run, write(map, std::string("\x1f\x8b\x08\0\0\0\0\0\0\x03", 10)), 1, {map, "gzip"}},
      {"like: tile-compressed", run, tile_compress(map), 1, {map, "compressed"}},
      {"like: truncated", run, cut(map, 20000), 1, {map, "truncated"}},
      {"like: cut before INSTRUMENT", run, cut(map, 2880 + 20160 - 2880), 1, {map}},
      {"like: INSTRUMENT renamed", run, overwrite_bytes(map, "'INSTRUMENT'", "'INSTRUMENX'"), 1, {map, "INSTRUMENT"}},
      {"like: INSTRUMENT's column renamed", run, overwrite_bytes(map, "'TOML    '", "'YAML    '"), 1, {map, "TOML"}},
      {"like: INSTRUMENT no TOML",
       run,
       overwrite_bytes(map, "distance_mm = 325", "distance_mm = =25"),
       1,
       {map, "INSTRUMENT"}},
      {"like: INSTRUMENT with a bad value",
       run,
       overwrite_bytes(map, "distance_mm = 325", "distance_mm = -25"),
       1,
       {map, "INSTRUMENT", "detector.distance_mm"}},
      {"like: stage angle missing", run, overwrite_bytes(map, "STAGERAD", "STAGEXXX"), 1, {map, "STAGERAD"}},
      {"like: stage at grazing incidence", run, card(map, "STAGERAD", "1.5707963267948966"), 1, {map, "stage"}},
  };
}

}  // namespace scatmap::test
