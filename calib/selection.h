#pragma once
#include <Eigen/Core>
#include <vector>

#include "calib/linearisation.h"

namespace scatmap::calib {

/// Takes away the priors that the targets overrule: those that carry less than 1 % of a parameter's information, and
/// those that the targets contradict (3 sigma away) and can do without (less than half of it). What is left are the
/// priors of parameters to which the targets are blind; a nominal value that is far off pulls nothing else. Priors of
/// Role::kPrior stay. @returns true if any went
bool drop_overruled_priors(Linearisation& at, const ParameterTable& table);

struct SelectOptions {
  double threshold = 0;     ///< a parameter stays if leaving it out raises chi² by more
  double tolerance_px = 0;  ///< a parameter to which the targets are blind stays if it may move a direction by more
};

/// Which parameters of a linearised fit the data need: backward elimination over nested sets, each step leaving out the
/// parameter whose return to its nominal value costs least chi², while that is below the threshold; among those within
/// 1 of the least, the one of the highest rank. Only Role::kOptional is left out.
/// @param away    (value − nominal) / scale of each parameter
/// @param effects directions in pixels per scaled parameter (effects_of)
/// @returns one flag per parameter of the set
/// @throws Error if the targets do not determine the set
std::vector<bool> needed(const Linearisation& at, const ParameterTable& table, const Eigen::VectorXd& away,
                         const Eigen::MatrixXd& effects, const SelectOptions& options);

/// What leaving out one parameter costs.
struct LeftOutCost {
  double chi2 = 0;      ///< gain of chi² if it were fitted too
  double bound_px = 0;  ///< largest shift of a direction: estimate and two standard deviations
};

/// @param with      linearisation at the solution of the set without the parameter; its last parameter is the left-out
/// one
/// @param effects   effects_of(…, with.set)
LeftOutCost left_out_cost(const Linearisation& with, const Eigen::MatrixXd& effects);

/// Covariance of every parameter of a set of which some were left out at their nominal values: what a fit of the others
/// says, and what the left-out ones, wherever they really are, do to it. Their own place is known from a fit of
/// everything: its estimate and covariance. Without this a smaller model would look more certain than the bench is.
/// @param whole  linearisation of the whole set at the solution without the left-out ones
/// @param fitted covariance of the kept parameters alone, in their order
/// @throws Error if the targets and priors do not determine the whole set
Eigen::MatrixXd covariance_with_left_out(const Linearisation& whole, const ParameterTable& table,
                                         const std::vector<bool>& kept, const Eigen::MatrixXd& fitted);

}  // namespace scatmap::calib
