#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calib/parameters.h"
#include "calib/targets.h"
#include "calib/trace.h"

namespace scatmap::calib {

/// A parameter in a fit. Inside the solver it is (value − origin) / scale, of order 1.
struct Fitted {
  Eigen::Index index = 0;             ///< in the ParameterTable
  double origin = 0;                  ///< m or rad
  double scale = 1;                   ///< m or rad
  std::optional<double> prior_sigma;  ///< m or rad; absent: only the targets decide
  double prior_centre = 0;            ///< m or rad
};
using FitSet = std::vector<Fitted>;

/// Which targets take part: indices into the list, ascending.
using Used = std::vector<std::size_t>;

/// Targets of one setting share one encoder error: lines that follow each other with the same kind, mount and angles.
/// Each block holds the inverse Cholesky factor of its residuals' joint covariance,
/// σ_px² I + J_enc diag(σ_stage², σ_arm²) J_encᵀ, the encoder errors marginalised.
struct WhiteningBlock {
  std::size_t first = 0;  ///< place in Used
  std::size_t count = 1;
  Eigen::Matrix2d single = Eigen::Matrix2d::Zero();  ///< when count = 1
  Eigen::MatrixXd several;                           ///< otherwise
};
using Whitening = std::vector<WhiteningBlock>;

class TargetModel {
 public:
  TargetModel(const ParameterTable& table, const TargetList& list) : table_(table), list_(list) {}
  const ParameterTable& table() const { return table_; }
  const TargetList& list() const { return list_; }

  /// Predicted spot and derivatives; nothing where the beam misses.
  std::optional<Trace> trace(const Eigen::VectorXd& values, std::size_t target) const;
  /// Covariance of one target's (column, row), px², encoder errors included.
  Eigen::Matrix2d covariance(const Target& target, const Trace& trace) const;
  /// Nothing if a used target's beam misses the detector plane.
  std::optional<Whitening> whitening(const Eigen::VectorXd& values, const Used& used) const;

  /// Whitened residuals, predicted less observed: 2 rows per used target, column before row (under the whitening the
  /// second is the row given the column), and their derivatives with respect to the scaled parameters of `set`.
  /// @param residuals 2·used.size() numbers
  /// @param jacobian  2·used.size() × set.size(), row after row; nullptr: not wanted
  /// @returns false if a used target's beam misses the detector plane: such values are infeasible
  bool evaluate(const Eigen::VectorXd& values, const Used& used, const Whitening& whitening, const FitSet& set,
                double* residuals, double* jacobian) const;

 private:
  Shot shot_of(const Eigen::VectorXd& values, const Target& target) const;
  bool same_setting(const Target& a, const Target& b) const;

  const ParameterTable& table_;
  const TargetList& list_;
};

/// Every target of a list.
Used all_targets(const TargetList& list);

}  // namespace scatmap::calib
