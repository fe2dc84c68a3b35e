#include "calib/consensus.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "scatmap/base/error.h"

namespace scatmap::calib {
namespace {

[[noreturn]] void fail(const TargetModel& model, const std::string& problem, const std::string& got) {
  throw Error({model.list().name, problem, got,
               "angles, kind and mount as they were, sigma_px not ten times too small, and a nominal instrument that "
               "resembles the bench, its pitch_um, columns, rows and flips right"});
}

void check_majority(const TargetModel& model, const Used& used) {
  const std::size_t all = model.list().targets.size();
  // Of two equal halves that contradict each other nobody can say which is right.
  if (2 * used.size() > all) return;
  fail(model, "does not agree with itself: half of the targets or more fit no common bench",
       std::to_string(used.size()) + " of " + std::to_string(all) + " agree");
}

// The start's predictions may miss the detector for targets whose labels are wrong.
Used feasible(const TargetModel& model, const Used& used, const Eigen::VectorXd& values) {
  Used out;
  std::copy_if(used.begin(), used.end(), std::back_inserter(out),
               [&](std::size_t i) { return model.trace(values, i).has_value(); });
  return out;
}

Solution solved(const TargetModel& model, const Used& used, const FitSet& set, const Eigen::VectorXd& start,
                const SolveOptions& options) {
  if (auto solution = solve(model, used, set, start, options)) return *solution;
  fail(model, "leads to no fit", std::to_string(used.size()) + " targets");
}

}  // namespace

std::vector<double> distances(const TargetModel& model, const Eigen::VectorXd& values) {
  std::vector<double> out;
  for (std::size_t i = 0; i < model.list().targets.size(); ++i) {
    const Target& t = model.list().targets[i];
    const auto trace = model.trace(values, i);
    if (!trace) {
      out.push_back(std::numeric_limits<double>::infinity());
      continue;
    }
    const Eigen::Vector2d r = trace->pixel - Eigen::Vector2d(t.column_px, t.row_px);
    out.push_back(std::sqrt(r.dot(model.covariance(t, *trace).inverse() * r)));
  }
  return out;
}

double disagreement(const std::vector<double>& distance) {
  double sum = 0;
  for (const double d : distance) sum += std::log1p(std::min(d, 1e6) * std::min(d, 1e6) / 4);
  return sum / static_cast<double>(distance.size());
}

Used within(const std::vector<double>& distance, double reject_sigma) {
  std::vector<double> sorted = distance;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  constexpr double kMedianOfTwo = 1.1774100225154747;  // sqrt(2 ln 2): of the distance in two dimensions
  constexpr double kWorstStated = 10;
  const double limit = reject_sigma * std::clamp(*middle / kMedianOfTwo, 1.0, kWorstStated);
  Used out;
  for (std::size_t i = 0; i < distance.size(); ++i) {
    if (distance[i] <= limit) out.push_back(i);
  }
  return out;
}

Consensus consensus(const TargetModel& model, const Used& near, const FitSet& set, const Eigen::VectorXd& start,
                    double reject_sigma, bool tight) {
  Consensus out{{}, feasible(model, near, start)};
  if (out.used.empty()) fail(model, "holds no target that the start can explain", {});
  const SolveOptions squares{Loss::kSquares, 2, tight};
  out.solution = solved(model, out.used, set, start, squares);
  Used next = within(distances(model, out.solution.values), reject_sigma);
  if (next == out.used) {
    check_majority(model, out.used);
    return out;
  }
  int iterations = out.solution.iterations;
  Solution robust = solved(model, out.used, set, start, {Loss::kCauchy, 3, false});
  // Twice: the first time the far group may still have bent the fit.
  for (int round = 0; round < 2; ++round) {
    iterations += robust.iterations;
    const Used reachable = feasible(model, within(distances(model, robust.values), 4 * reject_sigma), robust.values);
    if (reachable.empty()) break;
    robust = solved(model, reachable, set, robust.values, {Loss::kCauchy, 3, false});
  }
  iterations += robust.iterations;
  out.solution = robust;
  constexpr int kRounds = 10;
  out.used.clear();
  for (int round = 0; round < kRounds; ++round) {
    next = within(distances(model, out.solution.values), reject_sigma);
    if (next == out.used || next.empty()) break;
    out.used = next;
    out.solution = solved(model, out.used, set, out.solution.values, squares);
    iterations += out.solution.iterations;
  }
  out.solution.iterations = iterations;
  check_majority(model, out.used);
  return out;
}

}  // namespace scatmap::calib
