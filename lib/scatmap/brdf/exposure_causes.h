#pragma once
#include <Eigen/Core>
#include <vector>

#include "scatmap/brdf/scale.h"

namespace scatmap {

/// The causes of several exposures' scales by identity: one object per physical cause, one sensitivity per exposure.
struct ExposureCauses {
  std::vector<ScaleCause> causes;  ///< sensitivity 1
  Eigen::MatrixXd sensitivity;     ///< sample exposures × causes: d ln(factor of the exposure) / d cause
  Eigen::MatrixXd reference;       ///< signature exposures × causes, each by itself; may have no rows

  /// Acts alike on every sample exposure.
  bool is_common(std::size_t cause) const;
  /// Acts differently on exposures that show the same light, so that their overlap tells something of it.
  bool is_measurable(std::size_t cause) const;
  /// Variances of the causes, as stated.
  Eigen::VectorXd variances() const;
  /// Sample exposures first, then the signature's.
  Eigen::MatrixXd all_rows() const;

  /// The sample's sensitivities are relative to the first signature exposure; makes them relative to the sum of all,
  /// each with its share (adding to 1; as many as `reference` has rows).
  void refer_to(const std::vector<double>& share);
  /// One more cause, alike on every sample exposure.
  void add_common(ScaleCause cause);
};

/// What is named "… of the sample" is a different object in every exposure; any other name is one object.
/// @param budgets of the sample exposures, each relative to the first signature exposure
/// @param reference of the signature exposures; none: there is only one
ExposureCauses causes_by_identity(const std::vector<ScaleBudget>& budgets,
                                  const std::vector<ScaleBudget>& reference = {});

}  // namespace scatmap
