#include "calib/solve.h"

#include <ceres/ceres.h>

#include <algorithm>

namespace scatmap::calib {
namespace {

Eigen::VectorXd values_at(const Eigen::VectorXd& start, const FitSet& set, const double* x) {
  Eigen::VectorXd values = start;
  for (std::size_t k = 0; k < set.size(); ++k) values[set[k].index] = set[k].origin + set[k].scale * x[k];
  return values;
}

struct Fit {
  const TargetModel& model;
  const FitSet& set;
  const Eigen::VectorXd& start;
};

// Whitened residuals of some targets; all of them in one block is what makes a fit quick.
class TargetCost : public ceres::CostFunction {
 public:
  TargetCost(const Fit& fit, Used used, Whitening whitening)
      : fit_(fit), used_(std::move(used)), whitening_(std::move(whitening)) {
    set_num_residuals(static_cast<int>(2 * used_.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(fit.set.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    double* const jacobian = jacobians == nullptr ? nullptr : jacobians[0];
    return fit_.model.evaluate(values_at(fit_.start, fit_.set, parameters[0]), used_, whitening_, fit_.set, residuals,
                               jacobian);
  }

 private:
  Fit fit_;
  Used used_;
  Whitening whitening_;
};

class PriorCost : public ceres::CostFunction {
 public:
  explicit PriorCost(const FitSet& set) : set_(set) {
    set_num_residuals(static_cast<int>(
        std::count_if(set.begin(), set.end(), [](const Fitted& f) { return f.prior_sigma.has_value(); })));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(set.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    std::size_t row = 0;
    for (std::size_t k = 0; k < set_.size(); ++k) {
      const Fitted& f = set_[k];
      if (!f.prior_sigma) continue;
      residuals[row] = (f.origin + f.scale * parameters[0][k] - f.prior_centre) / *f.prior_sigma;
      if (jacobians != nullptr && jacobians[0] != nullptr) {
        std::fill_n(jacobians[0] + row * set_.size(), set_.size(), 0.0);
        jacobians[0][row * set_.size() + k] = f.scale / *f.prior_sigma;
      }
      ++row;
    }
    return true;
  }

 private:
  const FitSet& set_;
};

void add_targets(const Fit& fit, const Used& used, const Whitening& whitening, Loss loss, double* x,
                 ceres::Problem& problem) {
  if (loss == Loss::kSquares) {
    problem.AddResidualBlock(new TargetCost(fit, used, whitening), nullptr, x);
    return;
  }
  constexpr double kCauchyScale = 2;
  for (const WhiteningBlock& block : whitening) {
    const auto first = used.begin() + static_cast<std::ptrdiff_t>(block.first);
    WhiteningBlock alone = block;
    alone.first = 0;
    problem.AddResidualBlock(
        new TargetCost(fit, Used(first, first + static_cast<std::ptrdiff_t>(block.count)), {alone}),
        new ceres::CauchyLoss(kCauchyScale), x);
  }
}

// Nothing is left to find once a step fails to improve the cost by less than the cost's rounding, or the residuals of
// exact targets have sunk to 1e-10 of a standard deviation.
class StopAtRounding : public ceres::IterationCallback {
 public:
  explicit StopAtRounding(int residuals) : exact_(0.5e-20 * residuals) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& s) override {
    constexpr double kRounding = 1e-11;
    const bool still = s.iteration > 0 && !s.step_is_successful && std::abs(s.cost_change) <= kRounding * s.cost;
    return still || s.cost <= exact_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  double exact_;
};

ceres::Solver::Options ceres_options(const SolveOptions& options, bool last_pass) {
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::DENSE_QR;
  o.logging_type = ceres::SILENT;
  o.max_num_iterations = 100;
  o.initial_trust_region_radius = 1e8;  // the start is close: Gauss-Newton until that fails
  o.max_trust_region_radius = 1e20;
  // A curved valley (detector pitch) is followed to its floor only where the answer is used.
  const bool tight = last_pass && options.tight;
  o.function_tolerance = tight ? 1e-11 : 1e-4;
  o.parameter_tolerance = tight ? 1e-13 : 1e-8;
  o.gradient_tolerance = 1e-10;
  return o;
}

}  // namespace

std::optional<Solution> solve(const TargetModel& model, const Used& used, const FitSet& set,
                              const Eigen::VectorXd& start, const SolveOptions& options) {
  Solution out;
  out.values = start;
  if (set.empty()) {
    auto whitening = model.whitening(start, used);
    if (!whitening) return std::nullopt;
    out.whitening = std::move(*whitening);
    out.converged = true;
    return out;
  }
  std::vector<double> x(set.size());
  for (std::size_t k = 0; k < set.size(); ++k) x[k] = (start[set[k].index] - set[k].origin) / set[k].scale;
  for (int pass = 1; pass <= options.passes; ++pass) {
    auto whitening = model.whitening(out.values, used);
    if (!whitening) return std::nullopt;
    out.whitening = std::move(*whitening);
    ceres::Problem problem;
    const Fit fit{model, set, start};
    add_targets(fit, used, out.whitening, options.loss, x.data(), problem);
    if (std::any_of(set.begin(), set.end(), [](const Fitted& f) { return f.prior_sigma.has_value(); })) {
      problem.AddResidualBlock(new PriorCost(set), nullptr, x.data());
    }
    ceres::Solver::Summary summary;
    ceres::Solver::Options solver = ceres_options(options, pass == options.passes);
    StopAtRounding stop(problem.NumResiduals());
    solver.callbacks.push_back(&stop);
    ceres::Solve(solver, &problem, &summary);
    if (!summary.IsSolutionUsable()) return std::nullopt;
    out.values = values_at(start, set, x.data());
    out.cost = 2 * summary.final_cost;
    out.iterations += summary.num_successful_steps + summary.num_unsuccessful_steps - 1;
    out.converged = summary.termination_type == ceres::CONVERGENCE || summary.termination_type == ceres::USER_SUCCESS;
  }
  return out;
}

}  // namespace scatmap::calib
