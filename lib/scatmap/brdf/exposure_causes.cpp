#include "scatmap/brdf/exposure_causes.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace scatmap {
namespace {

std::string name_in(const std::string& name, std::size_t exposure, std::size_t exposures) {
  static const std::string kOwn = " of the sample";
  if (exposures < 2 || !name.ends_with(kOwn)) return name;
  return name.substr(0, name.size() - kOwn.size()) + " of exposure " + std::to_string(exposure + 1);
}

}  // namespace

ExposureCauses causes_by_identity(const std::vector<ScaleBudget>& budgets) {
  ExposureCauses out;
  const auto exposures = static_cast<Eigen::Index>(budgets.size());
  out.sensitivity.resize(exposures, 0);
  for (std::size_t e = 0; e < budgets.size(); ++e) {
    for (ScaleCause cause : budgets[e].causes) {
      cause.name = name_in(cause.name, e, budgets.size());
      auto found =
          std::find_if(out.causes.begin(), out.causes.end(), [&](const ScaleCause& c) { return c.name == cause.name; });
      const auto column = found - out.causes.begin();
      const double sensitivity = cause.sensitivity;
      if (found == out.causes.end()) {
        cause.sensitivity = 1;
        out.causes.push_back(std::move(cause));
        out.sensitivity.conservativeResizeLike(Eigen::MatrixXd::Zero(exposures, column + 1));
      }
      out.sensitivity(static_cast<Eigen::Index>(e), column) = sensitivity;
    }
  }
  return out;
}

bool ExposureCauses::is_common(std::size_t cause) const {
  const auto column = sensitivity.col(static_cast<Eigen::Index>(cause));
  return (column.array() == column[0]).all();
}

Eigen::VectorXd ExposureCauses::variances() const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(causes.size()));
  for (std::size_t k = 0; k < causes.size(); ++k) out[static_cast<Eigen::Index>(k)] = std::pow(causes[k].standard(), 2);
  return out;
}

}  // namespace scatmap
