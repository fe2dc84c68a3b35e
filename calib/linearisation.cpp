#include "calib/linearisation.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "scatmap/base/error.h"

namespace scatmap::calib {
namespace {

constexpr double kWorstCondition = 1e9;
// A column this much shorter than the longest (per mechanical tolerance, both) is rounding: the targets see nothing of
// it, and stretched to unit length it would pass for a measurement.
constexpr double kRounding = 1e-11;

// Jacobian with prior rows, and the lengths of its columns.
struct Scaled {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd length;
};

Scaled scaled(const Linearisation& at) {
  const Eigen::Index n = at.jacobian.cols();
  Scaled out;
  out.matrix.resize(at.jacobian.rows() + n, n);
  out.matrix << at.jacobian, Eigen::MatrixXd(at.prior_information.cwiseSqrt().asDiagonal());
  out.length = out.matrix.colwise().norm();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (out.length[i] > kRounding * out.length.maxCoeff()) {
      out.matrix.col(i) /= out.length[i];
    } else {
      out.matrix.col(i).setZero();
    }
  }
  return out;
}

}  // namespace

Eigen::MatrixXd Linearisation::normal_matrix() const {
  Eigen::MatrixXd n = jacobian.transpose() * jacobian;
  n.diagonal() += prior_information;
  return n;
}

Eigen::VectorXd Linearisation::gradient() const {
  return jacobian.transpose() * residual + prior_information.cwiseProduct(from_prior);
}

Linearisation linearise(const TargetModel& model, const Used& used, const Whitening& whitening, const FitSet& set,
                        const Eigen::VectorXd& values) {
  const auto rows = static_cast<Eigen::Index>(2 * used.size()), n = static_cast<Eigen::Index>(set.size());
  Linearisation out;
  out.set = set;
  out.residual.resize(rows);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> jacobian(rows, n);
  if (!model.evaluate(values, used, whitening, set, out.residual.data(), jacobian.data())) {
    throw Error({model.list().name, "holds a target whose beam misses the detector", {}, {}});
  }
  out.jacobian = jacobian;
  out.prior_information = Eigen::VectorXd::Zero(n);
  out.from_prior = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Fitted& f = set[static_cast<std::size_t>(i)];
    if (!f.prior_sigma) continue;
    out.prior_information[i] = (f.scale / *f.prior_sigma) * (f.scale / *f.prior_sigma);
    out.from_prior[i] = (values[f.index] - f.prior_centre) / f.scale;
  }
  return out;
}

Spectrum spectrum(const Eigen::MatrixXd& matrix) {
  const Eigen::Index n = matrix.cols();
  if (n == 0) return {};
  Eigen::MatrixXd triangle = matrix;
  if (matrix.rows() > n)
    triangle = Eigen::HouseholderQR<Eigen::MatrixXd>(matrix).matrixQR().topRows(n).triangularView<Eigen::Upper>();
  if (triangle.rows() < n) triangle.conservativeResizeLike(Eigen::MatrixXd::Zero(n, n));
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(triangle, Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixV()};
}

std::optional<Uncertainty> uncertainty(const Linearisation& at) {
  if (at.set.empty()) return Uncertainty{Eigen::MatrixXd(0, 0), 1};
  const Scaled s = scaled(at);
  const Spectrum sp = spectrum(s.matrix);
  const double condition = sp.values[0] / sp.values[sp.values.size() - 1];
  if (!(condition < kWorstCondition)) return std::nullopt;
  const Eigen::MatrixXd root =
      s.length.cwiseInverse().asDiagonal() * sp.vectors * sp.values.cwiseInverse().asDiagonal();
  return Uncertainty{root * root.transpose(), condition};
}

std::string singular_names(const Linearisation& at, const ParameterTable& table) {
  const Scaled s = scaled(at);
  const Spectrum sp = spectrum(s.matrix);
  std::string names;
  for (Eigen::Index i = 0; i < sp.values.size(); ++i) {
    if (sp.values[i] * kWorstCondition > sp.values[0]) continue;
    names += (names.empty() ? "" : "; ") +
             direction_names(sp.vectors.col(i).cwiseQuotient(s.length.cwiseMax(1e-300)), at.set, table);
  }
  return names;
}

std::string direction_names(const Eigen::VectorXd& direction, const FitSet& set, const ParameterTable& table) {
  constexpr double kLarge = 0.15;  // of the largest component
  std::vector<Eigen::Index> order(set.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::sort(order.begin(), order.end(),
            [&](Eigen::Index a, Eigen::Index b) { return std::abs(direction[a]) > std::abs(direction[b]); });
  constexpr std::size_t kMost = 6;
  std::string names;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (std::abs(direction[order[k]]) < kLarge * std::abs(direction[order.front()])) break;
    if (k == kMost) return names + " and others";
    names += (names.empty() ? "" : ", ") + table[set[static_cast<std::size_t>(order[k])].index].name;
  }
  return names;
}

}  // namespace scatmap::calib
