#include "calib/selection.h"

#include <algorithm>
#include <cmath>

#include "scatmap/base/error.h"

namespace scatmap::calib {
namespace {

Uncertainty determined(const Linearisation& at, const ParameterTable& table) {
  if (auto u = uncertainty(at)) return *u;
  throw Error({"calibration", "is not determined: the targets cannot tell apart what is left free without a prior",
               singular_names(at, table), "--fix or --prior for one of them, or more kinds of targets"});
}

// A Gaussian estimate in which parameters can be set to their nominal values, one after the other.
class Estimate {
 public:
  Estimate(Eigen::MatrixXd covariance, Eigen::VectorXd away)
      : covariance_(std::move(covariance)), away_(std::move(away)) {}

  double variance(Eigen::Index i) const { return covariance_(i, i); }
  double chi2(Eigen::Index i) const { return away_[i] * away_[i] / variance(i); }
  // Whether fixing i moves some direction by more than the tolerance and half of that direction's own uncertainty then.
  bool moves_directions(Eigen::Index i, const Eigen::MatrixXd& effects, double tolerance_px) const {
    constexpr double kShare = 0.5;
    const double size = std::abs(away_[i]) + 2 * std::sqrt(variance(i));
    const Eigen::VectorXd with = effects * covariance_.col(i) / variance(i);  // directions per unit of i
    const Eigen::VectorXd left =
        (effects * covariance_).cwiseProduct(effects).rowwise().sum() - with.cwiseAbs2() * variance(i);
    const Eigen::VectorXd allowed = (kShare * left.cwiseMax(0).cwiseSqrt()).cwiseMax(tolerance_px);
    return ((with.cwiseAbs() * size).array() > allowed.array()).any();
  }
  void set_to_nominal(Eigen::Index i) {
    const Eigen::VectorXd gain = covariance_.col(i) / variance(i);
    away_ -= gain * away_[i];
    covariance_ -= gain * covariance_.row(i);
    covariance_.row(i).setZero();
    covariance_.col(i).setZero();
  }

 private:
  Eigen::MatrixXd covariance_;
  Eigen::VectorXd away_;
};

}  // namespace

bool drop_overruled_priors(Linearisation& at, const ParameterTable& table) {
  constexpr double kNegligible = 0.01, kContradicted = 3, kAlone = 0.5;
  bool dropped = false;
  for (;;) {
    const Eigen::MatrixXd covariance = determined(at, table).covariance;
    Eigen::Index least = -1;
    double least_share = kAlone;
    for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
      const Fitted& f = at.set[static_cast<std::size_t>(i)];
      if (!f.prior_sigma || table[f.index].role == Role::kPrior) continue;
      const double share = covariance(i, i) * at.prior_information[i];
      const bool contradicted = std::abs(at.from_prior[i]) * std::sqrt(at.prior_information[i]) > kContradicted;
      if (share < least_share && (share < kNegligible || contradicted)) {
        least = i;
        least_share = share;
      }
    }
    if (least < 0) return dropped;
    at.set[static_cast<std::size_t>(least)].prior_sigma.reset();
    at.prior_information[least] = 0;
    at.from_prior[least] = 0;
    dropped = true;
  }
}

std::vector<bool> needed(const Linearisation& at, const ParameterTable& table, const Eigen::VectorXd& away,
                         const Eigen::MatrixXd& effects, const SelectOptions& options) {
  constexpr double kBlind = 0.05;  // share of a parameter's information that its prior brings
  constexpr double kAlike = 1;     // chi²
  Estimate estimate(determined(at, table).covariance, away);
  std::vector<bool> kept(at.set.size(), true);
  for (;;) {
    std::vector<Eigen::Index> removable;
    double least = options.threshold;
    for (Eigen::Index i = 0; i < at.jacobian.cols(); ++i) {
      const Parameter& p = table[at.set[static_cast<std::size_t>(i)].index];
      if (!kept[static_cast<std::size_t>(i)] || p.role != Role::kOptional || !(estimate.chi2(i) <= options.threshold))
        continue;
      const bool blind = estimate.variance(i) * at.prior_information[i] > kBlind;
      if (blind && estimate.moves_directions(i, effects, options.tolerance_px)) continue;
      removable.push_back(i);
      least = std::min(least, estimate.chi2(i));
    }
    Eigen::Index out = -1;
    for (const Eigen::Index i : removable) {
      if (estimate.chi2(i) > least + kAlike) continue;
      const auto rank = [&](Eigen::Index k) { return table[at.set[static_cast<std::size_t>(k)].index].rank; };
      if (out < 0 || rank(i) > rank(out) || (rank(i) == rank(out) && estimate.chi2(i) < estimate.chi2(out))) out = i;
    }
    if (out < 0) return kept;
    kept[static_cast<std::size_t>(out)] = false;
    estimate.set_to_nominal(out);
  }
}

LeftOutCost left_out_cost(const Linearisation& with, const Eigen::MatrixXd& effects) {
  const auto u = uncertainty(with);
  if (!u) return {0, 0};  // an exact gauge: it changes nothing
  const Eigen::Index last = with.jacobian.cols() - 1;
  const double variance = u->covariance(last, last);
  const double estimate = -u->covariance.row(last).dot(with.gradient());
  const double shift = (effects * u->covariance.col(last)).cwiseAbs().maxCoeff() / variance;
  return {estimate * estimate / variance, shift * (std::abs(estimate) + 2 * std::sqrt(variance))};
}

Eigen::MatrixXd covariance_with_left_out(const Linearisation& whole, const ParameterTable& table,
                                         const std::vector<bool>& kept, const Eigen::MatrixXd& fitted) {
  std::vector<Eigen::Index> in, out;
  for (std::size_t k = 0; k < kept.size(); ++k) (kept[k] ? in : out).push_back(static_cast<Eigen::Index>(k));
  if (out.empty()) return fitted;
  const Eigen::MatrixXd full = determined(whole, table).covariance;
  const Eigen::VectorXd estimate = -(full * whole.gradient())(out);
  const Eigen::MatrixXd second_moment = full(out, out) + estimate * estimate.transpose();
  // Errors of all parameters per unit of a left-out one: itself, and what the fit of the others makes of it.
  const auto n = static_cast<Eigen::Index>(kept.size()), m = static_cast<Eigen::Index>(out.size());
  Eigen::MatrixXd error = Eigen::MatrixXd::Zero(n, m);
  const Eigen::MatrixXd kept_jacobian = whole.jacobian(Eigen::all, in), left_jacobian = whole.jacobian(Eigen::all, out);
  error(in, Eigen::all) = fitted * (kept_jacobian.transpose() * left_jacobian);
  error(out, Eigen::all) = -Eigen::MatrixXd::Identity(m, m);
  Eigen::MatrixXd covariance = error * second_moment * error.transpose();
  covariance(in, in) += fitted;
  return covariance;
}

}  // namespace scatmap::calib
