#pragma once
#include <filesystem>
#include <string>

#include "scatmap/model/model.h"

namespace scatmap {

/// Reads and checks a model file (model.toml): `wavelength_nm`, `polarization` ("unpolarized", the default, "s" or
/// "p"), `phi_ref_deg`, and one or more [[term]] with `kind` and
/// - "microfacet": `rho`, `m`, `n = [re, im]` or `n_file` (a refractiveindex.info YAML file, relative to the model
/// file),
///   `dtheta_deg`, `dphi_deg` (0 when absent);
/// - "stripes": `rho`, `a_um`, `b_um`, `c_um`, `form` ("paper", the default, or "grating");
/// - "lambertian": `rho`.
/// @throws Error naming file, line and key
Model read_model(const std::filesystem::path& path);
/// The same from text; `name` stands for the file in messages, and `n_file` is looked for in its folder.
Model parse_model(const std::string& text, const std::string& name);

/// The file's text. Reading it gives the same doubles, bit for bit, for every model that was read from a file; a value
/// computed inside (a fitted angle, say) may have no exact counterpart in the file's units and then moves by its last
/// bit. An index from `n_file` is written as numbers.
std::string to_toml(const Model& model);

}  // namespace scatmap
