// The table of mechanical priors in docs/calibration.md is that of the code. Does not prove the tolerances sensible.
#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "calib/parameters.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/output_file.h"

namespace scatmap::calib {
namespace {

struct Row {
  std::string sigma, in_the_fit;
  bool operator==(const Row&) const = default;
};
using Rows = std::map<std::string, Row>;

std::string trimmed(const std::string& s) {
  const auto first = s.find_first_not_of(" `");
  return first == std::string::npos ? "" : s.substr(first, s.find_last_not_of(" `") - first + 1);
}

Rows in_the_document() {
  Rows out;
  std::istringstream text(read_text_file(SCATMAP_SOURCE_DIR "/docs/calibration.md"));
  bool inside = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("| parameter | standard deviation")) inside = true;
    if (!line.starts_with("|")) inside = false;
    if (!inside || !line.starts_with("| `")) continue;
    std::istringstream fields(line);
    std::string nothing, name, sigma, role;
    std::getline(fields, nothing, '|');
    std::getline(fields, name, '|');
    std::getline(fields, sigma, '|');
    std::getline(fields, role, '|');
    EXPECT_TRUE(out.emplace(trimmed(name), Row{trimmed(sigma), trimmed(role)}).second) << name;
  }
  return out;
}

Rows in_the_code() {
  Rows out;
  const ParameterTable table(Instrument{}, TargetList{"", {""}, {}}, {});
  for (Eigen::Index i = 0; i < table.size(); ++i) {
    const Parameter& p = table[i];
    const char* role = p.role == Role::kCore ? "always" : p.role == Role::kHeld ? "held" : "if needed";
    out[p.name] = {p.role == Role::kHeld ? "–" : number_text_in_unit(p.prior_sigma, p.unit), role};
  }
  return out;
}

TEST(PriorsDocument, TableIsThatOfTheCode) {
  const Rows document = in_the_document(), code = in_the_code();
  EXPECT_EQ(code.size(), kGeometryKeyCount);
  for (const auto& [name, row] : code) {
    ASSERT_TRUE(document.contains(name)) << name;
    EXPECT_EQ(document.at(name).sigma, row.sigma) << name;
    EXPECT_EQ(document.at(name).in_the_fit, row.in_the_fit) << name;
  }
  EXPECT_EQ(document.size(), code.size());
}

}  // namespace
}  // namespace scatmap::calib
