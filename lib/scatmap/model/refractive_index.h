#pragma once
#include <complex>
#include <filesystem>
#include <string>

namespace scatmap {

/// Index n + i k at a vacuum wavelength out of a material file of the refractiveindex.info database (YAML).
/// Understood: `tabulated nk`, `tabulated n`, `tabulated k` (linear between neighbours), `formula 1` and `formula 2`
/// (Sellmeier); one block that gives n, at most one beside it that gives k, and k = 0 without. Never extrapolated.
/// @throws Error naming file and line: an unknown kind of block, a line out of place, a table out of order, a
/// wavelength outside the data (the message holds the range)
std::complex<double> read_refractive_index(const std::filesystem::path& path, double wavelength_m);
/// The same from text; `name` stands for the file in messages.
std::complex<double> parse_refractive_index(const std::string& text, const std::string& name, double wavelength_m);

}  // namespace scatmap
