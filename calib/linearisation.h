#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calib/target_model.h"

namespace scatmap::calib {

/// A fit near its solution, in scaled parameters (Fitted::scale).
struct Linearisation {
  FitSet set;
  Eigen::MatrixXd jacobian;           ///< whitened, targets only: 2·used × set
  Eigen::VectorXd residual;           ///< whitened, predicted less observed
  Eigen::VectorXd prior_information;  ///< (scale / prior sigma)², 0 without a prior
  Eigen::VectorXd from_prior;         ///< (value − prior centre) / scale

  /// JᵀJ and the priors.
  Eigen::MatrixXd normal_matrix() const;
  /// Half the gradient of the cost: Jᵀr and the priors'.
  Eigen::VectorXd gradient() const;
};

/// @throws Error if a used target's beam misses the detector plane at `values`
Linearisation linearise(const TargetModel& model, const Used& used, const Whitening& whitening, const FitSet& set,
                        const Eigen::VectorXd& values);

/// Singular values (falling) and right singular vectors of a matrix, by QR and then SVD of its triangle.
struct Spectrum {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
Spectrum spectrum(const Eigen::MatrixXd& matrix);

/// Covariance of the scaled parameters from targets and priors, and how well conditioned that was.
struct Uncertainty {
  Eigen::MatrixXd covariance;  ///< scaled parameters
  double condition = 1;        ///< of the column-scaled Jacobian
};

/// From the singular values of the Jacobian with priors, its columns brought to length 1 so that units decide nothing.
/// @returns nothing where the matrix is singular (condition above 1e9): no number is better than a wrong one
std::optional<Uncertainty> uncertainty(const Linearisation& at);

/// The parameter names that make up the directions that leave `at` singular: "arm.zero_deg, stage.zero_deg".
std::string singular_names(const Linearisation& at, const ParameterTable& table);

/// Names of a direction's large components, largest first, joined by commas.
std::string direction_names(const Eigen::VectorXd& direction, const FitSet& set, const ParameterTable& table);

}  // namespace scatmap::calib
