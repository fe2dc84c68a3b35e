// Model files: what the keys mean, that writing and reading again gives the same doubles, and that bad files are
// refused with file, line and key. Not proven: that a value computed inside survives the change of units bit for bit;
// one last bit is allowed there.
#include "scatmap/model/model_toml.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "model/scene.h"
#include "scatmap/base/error.h"

namespace scatmap {
namespace {

const std::string kPaper = R"(wavelength_nm = 632.8
phi_ref_deg = 30.1

[[term]]
kind = "microfacet"
rho = 0.015
m = 2e-4
n = [3.6, 0]

[[term]]
kind = "microfacet"
rho = 0.7
m = 2e-4
n = [1.4, 0.01]
dtheta_deg = 0.5
dphi_deg = 45

[[term]]
kind = "stripes"
rho = 300
a_um = 800
b_um = 10
c_um = 40
form = "grating"

[[term]]
kind = "lambertian"
rho = 0.05
)";

std::vector<double> numbers(const Model& model) {
  std::vector<double> out{model.wavelength_m, model.phi_ref_rad};
  for (const Term& term : model.terms) {
    if (const auto* t = std::get_if<MicrofacetTerm>(&term)) {
      out.insert(out.end(), {t->rho, t->m, t->n.real(), t->n.imag(), t->dtheta_rad, t->dphi_rad});
    } else if (const auto* s = std::get_if<StripesTerm>(&term)) {
      out.insert(out.end(), {s->rho, s->a_m, s->b_m, s->c_m, s->form == StripesForm::kPaper ? 1.0 : 2.0});
    } else {
      out.push_back(std::get<LambertianTerm>(term).rho);
    }
  }
  return out;
}

TEST(ModelToml, MeansWhatItSays) {
  const Model model = parse_model(kPaper, "model.toml");
  EXPECT_EQ(model.polarization, Polarization::kUnpolarized);
  const std::vector<double> expected{
      632.8e-9, 30.1 * kRadPerDeg, 0.015,          2e-4, 3.6,  0,    0,    0, 0.7, 2e-4, 1.4,
      0.01,     0.5 * kRadPerDeg,  std::atan(1.0), 300,  8e-4, 1e-5, 4e-5, 2, 0.05};
  const std::vector<double> got = numbers(model);
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) EXPECT_DOUBLE_EQ(got[i], expected[i]) << i;
}

TEST(ModelToml, Polarisations) {
  EXPECT_EQ(parse_model("polarization = \"s\"\n" + kPaper, "f").polarization, Polarization::kS);
  EXPECT_EQ(parse_model("polarization = \"p\"\n" + kPaper, "f").polarization, Polarization::kP);
  EXPECT_EQ(parse_model("polarization = \"unpolarized\"\n" + kPaper, "f").polarization, Polarization::kUnpolarized);
}

TEST(ModelToml, ReadsBackBitForBit) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> u(0.001, 1);
  for (int k = 0; k < 2000; ++k) {
    Model written = parse_model(kPaper, "f");
    written.polarization = k % 3 == 0 ? Polarization::kS : k % 3 == 1 ? Polarization::kP : Polarization::kUnpolarized;
    written.wavelength_m = 1e-6 * u(random);
    written.phi_ref_rad = 6 * (u(random) - 0.5);
    written.terms = {
        MicrofacetTerm{u(random), u(random), {4 * u(random), u(random)}, -1.5 * u(random), 6 * u(random)},
        StripesTerm{1e4 * u(random), 1e-3 * u(random), 1e-5 * u(random), 1e-4 * u(random), StripesForm::kPaper},
        LambertianTerm{u(random)}};
    // The first reading brings every number onto the file's grid of units; from then on nothing may move.
    const Model first = parse_model(to_toml(written), "f");
    const std::vector<double> before = numbers(written), a = numbers(first);
    const std::vector<double> b = numbers(parse_model(to_toml(first), "f"));
    ASSERT_EQ(a.size(), before.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i], b[i]) << i;
      EXPECT_LE(std::abs(a[i] - before[i]), 2.3e-16 * std::abs(before[i])) << i;
    }
    EXPECT_EQ(first.polarization, written.polarization);
  }
}

// Products with the unit, as the reader makes them, are exact at once.
TEST(ModelToml, NumbersFromAFileAreExactAtOnce) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> u(0.001, 1);
  for (int k = 0; k < 5000; ++k) {
    const Model model{1000 * (0.001 + u(random)) * kMetrePerNm,
                      Polarization::kUnpolarized,
                      300 * u(random) * kRadPerDeg,
                      {StripesTerm{1, 1e3 * u(random) * kMetrePerUm, u(random) * kMetrePerUm,
                                   9 * u(random) * kMetrePerUm, StripesForm::kGrating}}};
    EXPECT_EQ(numbers(parse_model(to_toml(model), "f")), numbers(model));
  }
}

// Powers of two, where a plain division misses by one bit.
TEST(ModelToml, PowersOfTwoAreExactWhereTheFileCanSayThem) {
  int reachable = 0;
  for (int power = -28; power <= -1; ++power) {
    const double a_m = std::ldexp(1, power), near = a_m / kMetrePerUm;
    const double up = std::nextafter(near, 1e300), down = std::nextafter(near, 0);
    if (near * kMetrePerUm != a_m && up * kMetrePerUm != a_m && down * kMetrePerUm != a_m) continue;
    ++reachable;
    const Model model{632.8 * kMetrePerNm, Polarization::kUnpolarized, 0, {StripesTerm{1, a_m, 1e-6, 1e-6}}};
    EXPECT_EQ(numbers(parse_model(to_toml(model), "f"))[3], a_m) << power;
  }
  EXPECT_GT(reachable, 0);
  const Model blue{std::ldexp(1, -21), Polarization::kUnpolarized, 0, {LambertianTerm{1}}};  // 476.8 nm
  EXPECT_EQ(numbers(parse_model(to_toml(blue), "f"))[0], blue.wavelength_m);
}

TEST(ModelToml, IndexFromAMaterialFile) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "model_toml_test";
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(std::string(SCATMAP_TEST_DATA) + "/refractive_index/GaInP_Schubert.yml",
                             folder / "GaInP_Schubert.yml", std::filesystem::copy_options::overwrite_existing);
  std::ofstream(folder / "model.toml") << "wavelength_nm = 632.8\n[[term]]\nkind = \"microfacet\"\nrho = 1\nm = 0.1\n"
                                          "n_file = \"GaInP_Schubert.yml\"\n";
  const Model model = read_model(folder / "model.toml");
  const auto n = std::get<MicrofacetTerm>(model.terms.at(0)).n;
  EXPECT_NEAR(n.real(), 3.60363, 5e-6);
  EXPECT_NEAR(n.imag(), 0.1530, 5e-5);
  EXPECT_EQ(numbers(parse_model(to_toml(model), "elsewhere.toml")), numbers(model));
  std::filesystem::remove_all(folder);
}

TEST(ModelToml, MissingFile) { EXPECT_THROW(read_model("/no/such/model.toml"), Error); }

struct Bad {
  const char* line_and_key;
  const char* problem;
  std::string text;
};

std::string microfacet(const std::string& keys) {
  return "wavelength_nm = 632.8\n[[term]]\nkind = \"microfacet\"\n" + keys;
}
std::string stripes(const std::string& keys) { return "wavelength_nm = 632.8\n[[term]]\nkind = \"stripes\"\n" + keys; }
std::string lambertian(const std::string& head, const std::string& tail = "") {
  return head + "\n[[term]]\nkind = \"lambertian\"\nrho = 1\n" + tail;
}

std::vector<Bad> bad_files() {
  return {
      {"bad.toml:1: wavelength_nm", "is missing", lambertian("")},
      {"bad.toml:1: wavelength_nm", "out of range", lambertian("wavelength_nm = 0")},
      {"bad.toml:1: wavelength_nm", "out of range", lambertian("wavelength_nm = -632.8")},
      {"bad.toml:1: wavelength_nm", "out of range", lambertian("wavelength_nm = 632.8e-9")},
      {"bad.toml:1: wavelength_nm", "out of range", lambertian("wavelength_nm = nan")},
      {"bad.toml:1: wavelength_nm", "out of range", lambertian("wavelength_nm = inf")},
      {"bad.toml:1: wavelength_nm", "wrong type", lambertian("wavelength_nm = \"red\"")},
      {"bad.toml:2: polarization", "not known", lambertian("wavelength_nm = 632.8\npolarization = \"x\"")},
      {"bad.toml:2: polarization", "wrong type", lambertian("wavelength_nm = 632.8\npolarization = 1")},
      {"bad.toml:2: phi_ref_deg", "out of range", lambertian("wavelength_nm = 632.8\nphi_ref_deg = 361")},
      {"bad.toml:2: colour", "not a known key", lambertian("wavelength_nm = 632.8\ncolour = 1")},
      {"bad.toml:1: term", "is missing", "wavelength_nm = 632.8\n"},
      {"bad.toml:2: term", "is missing", "wavelength_nm = 632.8\nterm = []\n"},
      {"bad.toml:2: term", "wrong type", "wavelength_nm = 632.8\n[term]\nkind = \"lambertian\"\nrho = 1\n"},
      {"bad.toml:2: term.0.kind", "is missing", "wavelength_nm = 632.8\n[[term]]\nrho = 1\n"},
      {"bad.toml:3: term.0.kind", "not known", "wavelength_nm = 632.8\n[[term]]\nkind = \"phong\"\nrho = 1\n"},
      {"bad.toml:3: term.0.kind", "wrong type", "wavelength_nm = 632.8\n[[term]]\nkind = 3\nrho = 1\n"},
      {"bad.toml:2: term.0.rho", "is missing", microfacet("m = 0.1\nn = [1.5, 0]\n")},
      {"bad.toml:4: term.0.rho", "out of range", microfacet("rho = -1\nm = 0.1\nn = [1.5, 0]\n")},
      {"bad.toml:2: term.0.m", "is missing", microfacet("rho = 1\nn = [1.5, 0]\n")},
      {"bad.toml:5: term.0.m", "out of range", microfacet("rho = 1\nm = 0\nn = [1.5, 0]\n")},
      {"bad.toml:5: term.0.m", "out of range", microfacet("rho = 1\nm = -0.1\nn = [1.5, 0]\n")},
      {"bad.toml:2: term.0.n", "is missing", microfacet("rho = 1\nm = 0.1\n")},
      {"bad.toml:6: term.0.n", "wrong type", microfacet("rho = 1\nm = 0.1\nn = 1.5\n")},
      {"bad.toml:6: term.0.n", "wrong length", microfacet("rho = 1\nm = 0.1\nn = [1.5]\n")},
      {"bad.toml:6: term.0.n", "out of range", microfacet("rho = 1\nm = 0.1\nn = [0, 1]\n")},
      {"bad.toml:6: term.0.n", "out of range", microfacet("rho = 1\nm = 0.1\nn = [-1.5, 0]\n")},
      {"bad.toml:6: term.0.n", "out of range", microfacet("rho = 1\nm = 0.1\nn = [1.5, -0.1]\n")},
      {"bad.toml:6: term.0.n", "together", microfacet("rho = 1\nm = 0.1\nn = [1.5, 0]\nn_file = \"x.yml\"\n")},
      {"x.yml", "no such file", microfacet("rho = 1\nm = 0.1\nn_file = \"x.yml\"\n")},
      {"bad.toml:7: term.0.dtheta_deg", "out of range",
       microfacet("rho = 1\nm = 0.1\nn = [1.5, 0]\ndtheta_deg = 91\n")},
      {"bad.toml:7: term.0.dphi_deg", "out of range", microfacet("rho = 1\nm = 0.1\nn = [1.5, 0]\ndphi_deg = 400\n")},
      {"bad.toml:7: term.0.a_um", "not a known key", microfacet("rho = 1\nm = 0.1\nn = [1.5, 0]\na_um = 800\n")},
      {"bad.toml:2: term.0.a_um", "is missing", stripes("rho = 1\nb_um = 1\nc_um = 1\n")},
      {"bad.toml:5: term.0.a_um", "out of range", stripes("rho = 1\na_um = 0\nb_um = 1\nc_um = 1\n")},
      {"bad.toml:6: term.0.b_um", "out of range", stripes("rho = 1\na_um = 1\nb_um = -1\nc_um = 1\n")},
      {"bad.toml:7: term.0.c_um", "wrong type", stripes("rho = 1\na_um = 1\nb_um = 1\nc_um = true\n")},
      {"bad.toml:8: term.0.form", "not known", stripes("rho = 1\na_um = 1\nb_um = 1\nc_um = 1\nform = \"lines\"\n")},
      {"bad.toml:8: term.0.m", "not a known key", stripes("rho = 1\na_um = 1\nb_um = 1\nc_um = 1\nm = 1\n")},
      {"bad.toml:7: term.1.rho", "out of range",
       lambertian("wavelength_nm = 632.8", "[[term]]\nkind = \"lambertian\"\nrho = -1\n")},
      {"bad.toml:5: term.0.albedo", "not a known key", lambertian("wavelength_nm = 632.8", "albedo = 1\n")},
      {"bad.toml:1", "not valid TOML", "wavelength_nm = \n"},
  };
}

TEST(ModelToml, BadFilesAreRefusedWithLineAndKey) {
  const std::vector<Bad> files = bad_files();
  EXPECT_GE(files.size(), 25U);
  for (const Bad& bad : files) {
    try {
      parse_model(bad.text, "bad.toml");
      ADD_FAILURE() << "accepted:\n" << bad.text;
    } catch (const Error& e) {
      const std::string message = e.what();
      EXPECT_EQ(message.find(bad.line_and_key), 0U) << message << "\n" << bad.text;
      EXPECT_NE(message.find(bad.problem), std::string::npos) << message << "\n" << bad.text;
    }
  }
}

}  // namespace
}  // namespace scatmap
