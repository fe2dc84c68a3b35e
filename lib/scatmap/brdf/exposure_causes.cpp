#include "scatmap/brdf/exposure_causes.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace scatmap {
namespace {

std::string name_in(const std::string& name, std::size_t exposure, std::size_t exposures) {
  static const std::string kOwn = " of the sample";
  if (exposures < 2 || !name.ends_with(kOwn)) return name;
  return name.substr(0, name.size() - kOwn.size()) + " of exposure " + std::to_string(exposure + 1);
}

// One column more of zeros, in both matrices.
void add_column(ExposureCauses& c) {
  const auto grown = [](const Eigen::MatrixXd& m, Eigen::Index rows) {
    return Eigen::MatrixXd::Zero(rows, m.cols() + 1).eval();
  };
  Eigen::MatrixXd sensitivity = grown(c.sensitivity, c.sensitivity.rows()),
                  reference = grown(c.reference, c.reference.rows());
  sensitivity.leftCols(c.sensitivity.cols()) = c.sensitivity;
  reference.leftCols(c.reference.cols()) = c.reference;
  c.sensitivity = std::move(sensitivity);
  c.reference = std::move(reference);
}

Eigen::Index column_of(ExposureCauses& out, ScaleCause cause) {
  const auto found =
      std::find_if(out.causes.begin(), out.causes.end(), [&](const ScaleCause& c) { return c.name == cause.name; });
  const auto column = found - out.causes.begin();
  if (found == out.causes.end()) {
    cause.sensitivity = 1;
    out.causes.push_back(std::move(cause));
    add_column(out);
  }
  return column;
}

bool constant(const Eigen::MatrixXd& m, std::size_t cause) {
  if (m.rows() < 2) return true;
  const auto column = m.col(static_cast<Eigen::Index>(cause));
  return (column.array() == column[0]).all();
}

}  // namespace

ExposureCauses causes_by_identity(const std::vector<ScaleBudget>& budgets, const std::vector<ScaleBudget>& reference) {
  ExposureCauses out;
  out.sensitivity.resize(static_cast<Eigen::Index>(budgets.size()), 0);
  out.reference.resize(static_cast<Eigen::Index>(reference.size()), 0);
  for (std::size_t e = 0; e < budgets.size(); ++e) {
    for (ScaleCause cause : budgets[e].causes) {
      cause.name = name_in(cause.name, e, budgets.size());
      const Eigen::Index column = column_of(out, cause);
      out.sensitivity(static_cast<Eigen::Index>(e), column) = cause.sensitivity;
    }
  }
  for (std::size_t j = 0; j < reference.size(); ++j) {
    for (const ScaleCause& cause : reference[j].causes) {
      const Eigen::Index column = column_of(out, cause);
      out.reference(static_cast<Eigen::Index>(j), column) = cause.sensitivity;
    }
  }
  return out;
}

bool ExposureCauses::is_common(std::size_t cause) const { return constant(sensitivity, cause); }

bool ExposureCauses::is_measurable(std::size_t cause) const {
  return !constant(sensitivity, cause) || !constant(reference, cause);
}

Eigen::VectorXd ExposureCauses::variances() const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(causes.size()));
  for (std::size_t k = 0; k < causes.size(); ++k) out[static_cast<Eigen::Index>(k)] = std::pow(causes[k].standard(), 2);
  return out;
}

Eigen::MatrixXd ExposureCauses::all_rows() const {
  Eigen::MatrixXd out(sensitivity.rows() + reference.rows(), sensitivity.cols());
  out.topRows(sensitivity.rows()) = sensitivity;
  if (reference.rows() > 0) out.bottomRows(reference.rows()) = reference;
  return out;
}

void ExposureCauses::refer_to(const std::vector<double>& share) {
  if (reference.rows() < 2) return;
  Eigen::RowVectorXd change = Eigen::RowVectorXd::Zero(reference.cols());
  for (Eigen::Index j = 1; j < reference.rows(); ++j)
    change += share[static_cast<std::size_t>(j)] * (reference.row(0) - reference.row(j));
  sensitivity.rowwise() += change;
}

void ExposureCauses::add_common(ScaleCause cause) {
  const double of_cause = cause.sensitivity;
  const Eigen::Index column = column_of(*this, std::move(cause));
  sensitivity.col(column).setConstant(of_cause);
}

}  // namespace scatmap
