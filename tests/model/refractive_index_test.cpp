// Material files: indices at 632.8 nm as the database's own site prints them, ranges, interpolation, and that a file
// which is not quite understood is refused with its line. Not proven: formulas 3 to 9 and tabulated n2 (refused),
// general YAML (never read).
#include "scatmap/model/refractive_index.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "scatmap/base/error.h"

namespace scatmap {
namespace {

std::complex<double> index(const std::string& file, double nm) {
  return read_refractive_index(std::string(SCATMAP_TEST_DATA) + "/refractive_index/" + file, nm * 1e-9);
}

TEST(RefractiveIndex, AtTheHeliumNeonLine) {
  struct Known {
    const char* file;
    double n, k, n_tolerance, k_tolerance;
  };
  const std::vector<Known> known{{"GaInP_Schubert.yml", 3.60363, 0.1530, 5e-6, 5e-5},
                                 {"N-BK7.yml", 1.515089, 0, 5e-7, 2e-8},
                                 {"SiO2_Malitson.yml", 1.457018, 0, 5e-7, 0},
                                 {"Ag_Johnson.yml", 0.05625, 4.27603, 5e-6, 5e-6}};
  for (const Known& k : known) {
    const auto n = index(k.file, 632.8);
    EXPECT_NEAR(n.real(), k.n, k.n_tolerance) << k.file;
    EXPECT_NEAR(n.imag(), k.k, k.k_tolerance) << k.file;
  }
}

TEST(RefractiveIndex, IsNotExtrapolated) {
  try {
    index("GaInP_Kaneko.yml", 632.8);
    FAIL() << "632.8 nm lies outside Kaneko's data";
  } catch (const Error& e) {
    const std::string message = e.what();
    EXPECT_NE(message.find("0.6328 um"), std::string::npos) << message;
    EXPECT_NE(message.find("0.65 to 1.35 um"), std::string::npos) << message;
    EXPECT_NE(message.find("GaInP_Kaneko.yml:16"), std::string::npos) << message;
  }
  EXPECT_GT(index("GaInP_Kaneko.yml", 650).real(), 3);
  EXPECT_THROW(index("Ag_Johnson.yml", 187.8), Error);
  EXPECT_THROW(index("GaInP_Schubert.yml", 240), Error);
}

const std::string kTable = "DATA:\n  - type: tabulated nk\n    data: |\n        0.5 1.5 0.2\n        0.7 1.7 0.0\n";

TEST(RefractiveIndex, InterpolatesLinearlyAndMeetsItsRows) {
  const auto at = [](double nm) { return parse_refractive_index(kTable, "m.yml", nm * 1e-9); };
  EXPECT_NEAR(std::abs(at(500) - std::complex<double>(1.5, 0.2)), 0, 1e-15);
  EXPECT_NEAR(std::abs(at(700) - std::complex<double>(1.7, 0.0)), 0, 1e-15) << "the end itself is inside";
  EXPECT_THROW(at(700.001), Error);
  EXPECT_THROW(at(499.999), Error);
  EXPECT_NEAR(at(550).real(), 1.55, 1e-14);
  EXPECT_NEAR(at(550).imag(), 0.15, 1e-14);
}

TEST(RefractiveIndex, RefusesWhatItDoesNotUnderstand) {
  struct Bad {
    const char* text;
    const char* where;
    const char* problem;
  };
  const std::vector<Bad> bad{
      {"", "m.yml:", "holds no DATA"},
      {"COMMENTS: none\n", "m.yml:", "holds no DATA"},
      {"DATA:\n", "m.yml:", "holds no DATA"},
      {"DATA:\n  type: formula 1\n", "m.yml:2:", "is not understood"},
      {"DATA:\n  - type: formula 4\n", "m.yml:2:", "not supported"},
      {"DATA:\n  - type: tabulated n2\n", "m.yml:2:", "not supported"},
      {"DATA:\n  - type: tabulated nk\n", "m.yml:2:", "no complete data"},
      {"DATA:\n  - type: tabulated nk\n    data: 0.5 1 0\n", "m.yml:3:", "is not understood"},
      {"DATA:\n  - type: tabulated nk\n    data: |\n        0.5 1.5\n", "m.yml:4:", "number of columns"},
      {"DATA:\n  - type: tabulated nk\n    data: |\n        0.5 1.5 0 7\n", "m.yml:4:", "number of columns"},
      {"DATA:\n  - type: tabulated nk\n    data: |\n        0.5 x 0\n", "m.yml:4:", "not a number"},
      {"DATA:\n  - type: tabulated nk\n    data: |\n        0.5 nan 0\n", "m.yml:4:", "not a number"},
      {"DATA:\n  - type: tabulated nk\n    data: |\n        0.5 1,5 0\n", "m.yml:4:", "not a number"},
      {"DATA:\n  - type: tabulated nk\n    data: |\n        0.7 1.5 0\n        0.7 1.6 0\n",
       "m.yml:5:", "out of order"},
      {"DATA:\n  - type: tabulated nk\n    data: |\n        0.5 -1 0\n", "m.yml:4:", "impossible index"},
      {"DATA:\n  - type: tabulated nk\n    data: |\n        0.5 1 -0.1\n", "m.yml:4:", "impossible index"},
      {"DATA:\n  - type: tabulated k\n    data: |\n        0.5 1\n        0.7 1\n", "m.yml:", "gives no n"},
      {"DATA:\n  - type: formula 1\n    coefficients: 0 1 0.1\n", "m.yml:2:", "no complete data"},
      {"DATA:\n  - type: formula 1\n    wavelength_range: 0.5 0.7 1\n", "m.yml:3:", "not a range"},
      {"DATA:\n  - type: formula 1\n    wavelength_range: 0.7 0.5\n", "m.yml:3:", "not a range"},
      {"DATA:\n  - type: formula 1\n    wavelength_range: 0.5 0.7\n    coefficients: 0 1\n", "m.yml:4:", "even number"},
      {"DATA:\n  - type: formula 1\n    wavelength_range: 0.5 0.7\n    coefficients: -3\n",
       "m.yml:2:", "no real index"},
      {"DATA:\n  - type: formula 2\n    wavelength_range: 0.5 0.7\n    extra: 1\n", "m.yml:4:", "not understood here"},
      {"DATA:\n  - type: formula 2\n      wavelength_range: 0.5 0.7\n", "m.yml:3:", "indented wrongly"},
      {"\tDATA:\n", "m.yml:1:", "not understood here"},
      {"SURPRISE: 1\n", "m.yml:1:", "not understood here"},
      {"DATA: 1\n", "m.yml:1:", "not understood here"},
  };
  for (const Bad& b : bad) {
    try {
      parse_refractive_index(b.text, "m.yml", 600e-9);
      ADD_FAILURE() << "accepted:\n" << b.text;
    } catch (const Error& e) {
      const std::string message = e.what();
      EXPECT_EQ(message.find(b.where), 0U) << message << "\n" << b.text;
      EXPECT_NE(message.find(b.problem), std::string::npos) << message << "\n" << b.text;
    }
  }
}

TEST(RefractiveIndex, RefusesTwoSourcesOfOneQuantity) {
  const std::string second = "  - type: formula 1\n    wavelength_range: 0.5 0.7\n    coefficients: 1\n";
  EXPECT_THROW(parse_refractive_index(kTable + second, "m.yml", 600e-9), Error);
  EXPECT_THROW(parse_refractive_index(kTable + kTable, "m.yml", 600e-9), Error);
}

}  // namespace
}  // namespace scatmap
