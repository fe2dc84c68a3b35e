#include "calib/bootstrap.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "calib/linearisation.h"
#include "scatmap/base/error.h"
#include "scatmap/base/parallel.h"

namespace scatmap::calib {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// One trial's problem: whitened residuals weight·(r(θ) − shift), priors (θ − centre)/σ − prior_shift.
struct Draw {
  Eigen::VectorXd weight, shift, prior_shift;
};

// What all trials share: the fit of everything, its linearisation, and where to look.
class Bench {
 public:
  Bench(const TargetList& list, const CalibrationResult& result)
      : table_(result.instrument, list, {}), model_(table_, list), set_(result.set) {
    for (std::size_t i = 0; i < result.targets.size(); ++i) {
      if (result.targets[i].used) used_.push_back(i);
    }
    auto best = solve(model_, used_, set_, result.values);
    if (!best) throw Error({list.name, "leads to no fit of every parameter", {}, {}});
    best_ = std::move(*best);
    at_ = linearise(model_, used_, best_.whitening, set_, best_.values);
    effects_ = direction_effects(model_, used_, best_.values);
    const auto u = uncertainty(at_);
    if (!u) throw Error({list.name, "does not determine the parameters", singular_names(at_, table_), {}});
    root_prior_ = at_.prior_information.cwiseSqrt();
    const Eigen::VectorXd leverage = (at_.jacobian * u->covariance).cwiseProduct(at_.jacobian).rowwise().sum();
    full_residual_ = at_.residual.cwiseQuotient((1 - leverage.array()).max(1e-6).sqrt().matrix());
  }

  Eigen::Index rows() const { return at_.residual.size(); }
  Eigen::Index parameters() const { return static_cast<Eigen::Index>(set_.size()); }
  Eigen::Index numbers() const { return effects_.px_per_parameter.rows() + parameters(); }
  const FitSet& set() const { return set_; }
  const ParameterTable& table() const { return table_; }
  const DirectionEffects& effects() const { return effects_; }

  Draw draw(const BootstrapOptions& options, std::size_t trial) const;
  std::optional<Eigen::VectorXd> solved(const Draw& draw) const;
  /// Shifts of directions, px, and of parameters, scaled.
  Eigen::VectorXd shifts(const Eigen::VectorXd& values) const;

 private:
  ParameterTable table_;
  TargetModel model_;
  FitSet set_;
  Used used_;
  Solution best_;
  Linearisation at_;
  DirectionEffects effects_;
  Eigen::VectorXd root_prior_, full_residual_;
};

Draw Bench::draw(const BootstrapOptions& options, std::size_t trial) const {
  std::seed_seq seeds{static_cast<std::uint32_t>(options.seed), static_cast<std::uint32_t>(options.seed >> 32),
                      static_cast<std::uint32_t>(trial), static_cast<std::uint32_t>(trial >> 32)};
  std::mt19937_64 rng(seeds);
  std::normal_distribution<double> normal;
  Draw out{Eigen::VectorXd::Ones(rows()), Eigen::VectorXd::Zero(rows()), Eigen::VectorXd::Zero(parameters())};
  if (options.kind == BootstrapKind::kCases) {
    std::uniform_int_distribution<std::size_t> pick(0, best_.whitening.size() - 1);
    std::vector<double> times(best_.whitening.size(), 0);
    for (std::size_t k = 0; k < times.size(); ++k) times[pick(rng)] += 1;
    for (std::size_t k = 0; k < times.size(); ++k) {
      const WhiteningBlock& block = best_.whitening[k];
      out.weight.segment(static_cast<Eigen::Index>(2 * block.first), static_cast<Eigen::Index>(2 * block.count))
          .setConstant(std::sqrt(times[k]));
    }
  } else {
    std::uniform_int_distribution<Eigen::Index> pick(0, rows() / 2 - 1);
    const bool parametric = options.kind == BootstrapKind::kParametric;
    // Even rows are columns, odd ones rows given the column: each kind keeps its own residuals.
    for (Eigen::Index i = 0; i < rows(); ++i)
      out.shift[i] = at_.residual[i] + (parametric ? normal(rng) : full_residual_[2 * pick(rng) + i % 2]);
    out.prior_shift = root_prior_.cwiseProduct(at_.from_prior);
  }
  for (Eigen::Index k = 0; k < parameters(); ++k) out.prior_shift[k] += root_prior_[k] > 0 ? normal(rng) : 0;
  return out;
}

std::optional<Eigen::VectorXd> Bench::solved(const Draw& draw) const {
  constexpr int kSteps = 400;  // a handful; more where the valley bends
  Eigen::VectorXd values = best_.values, residual(rows()), step = Eigen::VectorXd::Zero(parameters());
  RowMajor jacobian(rows(), parameters());
  double last_cost = std::numeric_limits<double>::infinity(), length = 1;
  for (int k = 0; k < kSteps; ++k) {
    Eigen::VectorXd priors = -draw.prior_shift;
    for (Eigen::Index i = 0; i < parameters(); ++i) {
      const Fitted& f = set_[static_cast<std::size_t>(i)];
      if (f.prior_sigma) priors[i] += (values[f.index] - f.prior_centre) / *f.prior_sigma;
    }
    const bool seen = model_.evaluate(values, used_, best_.whitening, set_, residual.data(), jacobian.data());
    residual = draw.weight.cwiseProduct(residual - draw.shift);
    const double cost = seen ? residual.squaredNorm() + priors.squaredNorm() : std::numeric_limits<double>::infinity();
    const auto move = [&](double by) {
      for (Eigen::Index i = 0; i < parameters(); ++i)
        values[set_[static_cast<std::size_t>(i)].index] += by * step[i] * set_[static_cast<std::size_t>(i)].scale;
    };
    if (!(cost <= last_cost + kBootstrapDecrement)) {
      length /= 2;
      move(-length);  // back by half of what was gone
      continue;
    }
    last_cost = cost;
    jacobian.array().colwise() *= draw.weight.array();
    Eigen::MatrixXd normal_matrix = jacobian.transpose() * jacobian;
    normal_matrix.diagonal() += at_.prior_information;
    const Eigen::VectorXd gradient = jacobian.transpose() * residual + root_prior_.cwiseProduct(priors);
    const Eigen::LLT<Eigen::MatrixXd> factor(normal_matrix);
    if (factor.info() != Eigen::Success) return std::nullopt;
    step = -factor.solve(gradient);
    length = 1;
    move(1);
    if (-gradient.dot(step) < kBootstrapDecrement) return values;
  }
  return std::nullopt;
}

Eigen::VectorXd Bench::shifts(const Eigen::VectorXd& values) const {
  Eigen::VectorXd out(numbers());
  out << direction_shifts(model_, effects_, best_.values, values), Eigen::VectorXd(parameters());
  for (Eigen::Index i = 0; i < parameters(); ++i) {
    const Fitted& f = set_[static_cast<std::size_t>(i)];
    out[numbers() - parameters() + i] = (values[f.index] - best_.values[f.index]) / f.scale;
  }
  return out;
}

Eigen::MatrixXd scatter(const Eigen::MatrixXd& samples) {
  const Eigen::RowVectorXd mean = samples.colwise().mean();
  const Eigen::MatrixXd centred = samples.rowwise() - mean;
  return centred.transpose() * centred / static_cast<double>(samples.rows() - 1);
}

}  // namespace

Bootstrap bootstrap(const TargetList& list, const CalibrationResult& result, const BootstrapOptions& options) {
  constexpr int kMost = 10'000'000;
  if (options.trials < 2 || options.trials > kMost)
    throw Error({"bootstrap", "needs another number of trials", std::to_string(options.trials), "2 to 10 million"});
  const Bench bench(list, result);
  Eigen::MatrixXd samples(bench.numbers(), options.trials);
  for_each_index(options.trials, 1, [&](int k) {
    const auto values = bench.solved(bench.draw(options, static_cast<std::size_t>(k)));
    if (values) {
      samples.col(k) = bench.shifts(*values);
    } else {
      samples.col(k).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  });
  std::vector<Eigen::Index> good;
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    if (samples.col(k).allFinite()) good.push_back(k);
  }
  Bootstrap out;
  out.trials = options.trials;
  out.failed = options.trials - static_cast<int>(good.size());
  if (2 * out.failed >= options.trials)
    throw Error({list.name,
                 "leads to bootstrap trials without a fit",
                 std::to_string(out.failed) + " of " + std::to_string(out.trials) + " failed",
                 {}});
  const Eigen::MatrixXd covariance = scatter(samples(Eigen::all, good).transpose());
  for (std::size_t p = 0; p < bench.effects().points.size(); ++p) {
    const auto first = 2 * static_cast<Eigen::Index>(p);
    out.directions.push_back(
        direction_sigma(bench.effects(), p, Eigen::Matrix2d(covariance.block<2, 2>(first, first))));
  }
  for (Eigen::Index i = 0; i < bench.parameters(); ++i) {
    const Fitted& f = bench.set()[static_cast<std::size_t>(i)];
    const Eigen::Index at = bench.numbers() - bench.parameters() + i;
    out.parameter_sigma.push_back(std::sqrt(covariance(at, at)) * f.scale / bench.table()[f.index].unit);
  }
  return out;
}

}  // namespace scatmap::calib
