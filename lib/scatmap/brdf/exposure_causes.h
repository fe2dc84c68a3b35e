#pragma once
#include <Eigen/Core>
#include <vector>

#include "scatmap/brdf/scale.h"

namespace scatmap {

/// The causes of several exposures' scales by identity: one object per physical cause, one sensitivity per exposure.
struct ExposureCauses {
  std::vector<ScaleCause> causes;  ///< sensitivity 1
  Eigen::MatrixXd sensitivity;     ///< exposures × causes: d ln(factor of the exposure) / d cause

  /// Acts alike on every exposure.
  bool is_common(std::size_t cause) const;
  /// Variances of the causes, as stated.
  Eigen::VectorXd variances() const;
};

/// What is named "… of the sample" is a different object in every exposure; any other name is one object.
ExposureCauses causes_by_identity(const std::vector<ScaleBudget>& budgets);

}  // namespace scatmap
