#include "scatmap/model/model_toml.h"

#include <cmath>
#include <complex>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/toml_file.h"
#include "scatmap/base/units.h"
#include "scatmap/model/refractive_index.h"

namespace scatmap {
namespace {

// Wide enough for any surface, narrow enough that no square of a number overflows and a value in the wrong unit is
// noticed.
constexpr NumberRange kWavelength_nm{1, 1e6};
constexpr NumberRange kLength_um{1e-6, 1e9};
constexpr NumberRange kSlope{1e-9, 1e3};
constexpr NumberRange kWeight{0, 1e15};
constexpr NumberRange kIndex{0, 1e3};
constexpr NumberRange kTurn_deg{-360, 360};
constexpr NumberRange kTilt_deg{-90, 90};

Polarization polarization_named(const std::string& name) {
  if (name == "s") return Polarization::kS;
  return name == "p" ? Polarization::kP : Polarization::kUnpolarized;
}

std::string name_of(Polarization polarization) {
  if (polarization == Polarization::kS) return "s";
  return polarization == Polarization::kP ? "p" : "unpolarized";
}

std::complex<double> index_from(const TomlTable& table, double wavelength_m) {
  if (const auto file = table.optional_string("n_file")) {
    if (table.has("n")) throw Error({table.where("n"), "is given together with n_file", {}, "one of the two"});
    return read_refractive_index(table.resolve(*file), wavelength_m);
  }
  const std::vector<double> n = table.numbers("n", 2, kIndex);
  if (n[0] == 0) throw Error({table.where("n"), "is out of range", "a real part of 0", "a real part > 0"});
  return {n[0], n[1]};
}

MicrofacetTerm microfacet_from(const TomlTable& table, double wavelength_m) {
  return {table.number("rho", kWeight), table.number("m", kSlope), index_from(table, wavelength_m),
          table.number_or("dtheta_deg", 0, kTilt_deg) * kRadPerDeg,
          table.number_or("dphi_deg", 0, kTurn_deg) * kRadPerDeg};
}

StripesTerm stripes_from(const TomlTable& table) {
  const bool grating = table.choice("form", {"paper", "grating"}) == "grating";
  return {table.number("rho", kWeight), table.number("a_um", kLength_um) * kMetrePerUm,
          table.number("b_um", kLength_um) * kMetrePerUm, table.number("c_um", kLength_um) * kMetrePerUm,
          grating ? StripesForm::kGrating : StripesForm::kPaper};
}

Term term_from(const TomlTable& table, double wavelength_m) {
  const std::vector<std::string> kinds{"microfacet", "stripes", "lambertian"};
  if (!table.has("kind")) throw Error({table.where("kind"), "is missing", {}, "microfacet, stripes or lambertian"});
  const std::string kind = table.choice("kind", kinds);
  if (kind == "microfacet") return microfacet_from(table, wavelength_m);
  if (kind == "stripes") return stripes_from(table);
  return LambertianTerm{table.number("rho", kWeight)};
}

Model model_from(const TomlTable& file) {
  Model model;
  model.wavelength_m = file.number("wavelength_nm", kWavelength_nm) * kMetrePerNm;
  model.polarization = polarization_named(file.choice("polarization", {"unpolarized", "s", "p"}));
  model.phi_ref_rad = file.number_or("phi_ref_deg", 0, kTurn_deg) * kRadPerDeg;
  for (const TomlTable& table : file.tables("term")) model.terms.push_back(term_from(table, model.wavelength_m));
  if (model.terms.empty()) throw Error({file.where("term"), "is missing", {}, "at least one [[term]]"});
  file.reject_unknown_keys();
  return model;
}

std::string line(const std::string& key, const std::string& value) { return key + " = " + value + "\n"; }

std::string text_of(const MicrofacetTerm& term) {
  return line("kind", "\"microfacet\"") + line("rho", number_text(term.rho)) + line("m", number_text(term.m)) +
         line("n", std::string("[") + number_text(term.n.real()) + ", " + number_text(term.n.imag()) + "]") +
         line("dtheta_deg", number_text_in_unit(term.dtheta_rad, kRadPerDeg)) +
         line("dphi_deg", number_text_in_unit(term.dphi_rad, kRadPerDeg));
}

std::string text_of(const StripesTerm& term) {
  return line("kind", "\"stripes\"") + line("rho", number_text(term.rho)) +
         line("a_um", number_text_in_unit(term.a_m, kMetrePerUm)) +
         line("b_um", number_text_in_unit(term.b_m, kMetrePerUm)) +
         line("c_um", number_text_in_unit(term.c_m, kMetrePerUm)) +
         line("form", term.form == StripesForm::kPaper ? "\"paper\"" : "\"grating\"");
}

std::string text_of(const LambertianTerm& term) {
  return line("kind", "\"lambertian\"") + line("rho", number_text(term.rho));
}

}  // namespace

Model parse_model(const std::string& text, const std::string& name) { return model_from(TomlTable::parse(text, name)); }

Model read_model(const std::filesystem::path& path) { return model_from(TomlTable::read(path)); }

std::string to_toml(const Model& model) {
  std::string text = line("wavelength_nm", number_text_in_unit(model.wavelength_m, kMetrePerNm)) +
                     line("polarization", std::string("\"") + name_of(model.polarization) + "\"") +
                     line("phi_ref_deg", number_text_in_unit(model.phi_ref_rad, kRadPerDeg));
  for (const Term& term : model.terms) {
    text += "\n[[term]]\n" + std::visit([](const auto& t) { return text_of(t); }, term);
  }
  return text;
}

}  // namespace scatmap
