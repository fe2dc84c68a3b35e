#include "calib/joint_region.h"

#include "calib/linearisation.h"
#include "calib/solve.h"
#include "scatmap/base/error.h"

namespace scatmap::calib {
namespace {

double cost_at(const TargetModel& model, const Used& used, const Whitening& whitening, const FitSet& set,
               const Eigen::VectorXd& values) {
  const Linearisation at = linearise(model, used, whitening, set, values);
  return at.residual.squaredNorm() + (at.prior_information.array() * at.from_prior.array().square()).sum();
}

}  // namespace

double joint_chi2(const TargetList& list, const CalibrationResult& result, const Eigen::VectorXd& values) {
  const ParameterTable table(result.instrument, list, {});
  const TargetModel model(table, list);
  Used used;
  for (std::size_t i = 0; i < result.targets.size(); ++i) {
    if (result.targets[i].used) used.push_back(i);
  }
  const auto best = solve(model, used, result.set, result.values);
  if (!best) throw Error({list.name, "leads to no fit of every parameter", {}, {}});
  // One weighting for both: its own change with the parameters is no misfit.
  return cost_at(model, used, best->whitening, result.set, values) -
         cost_at(model, used, best->whitening, result.set, best->values);
}

}  // namespace scatmap::calib
