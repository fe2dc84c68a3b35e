#pragma once
#include <cstddef>
#include <variant>
#include <vector>

#include "scatmap/base/direction.h"
#include "scatmap/model/microfacet.h"
#include "scatmap/model/polarization_q.h"
#include "scatmap/model/stripes.h"

namespace scatmap {

/// The same BRDF, rho/pi, in every direction (paper, Eq. 5, last term).
struct LambertianTerm {
  double rho = 0;  ///< albedo, >= 0
};

using Term = std::variant<MicrofacetTerm, StripesTerm, LambertianTerm>;

/// A closed-form BRDF: the sum of its terms (paper, Sec. 4).
struct Model {
  double wavelength_m = 0;
  Polarization polarization = Polarization::kUnpolarized;
  double phi_ref_rad = 0;  ///< turn of the whole sample pattern about its normal, from +x towards +y
  std::vector<Term> terms;
};

/// A model for one incident direction: whatever depends on that direction only is computed once. The `exact` method:
/// double precision, no table, no approximation; a term whose exponential is 0 costs a few nanoseconds.
/// Directions are unit vectors away from the surface, in sample axes (z the normal, x forward).
class PreparedModel {
 public:
  /// `wi`: towards the source. `detector_distance_m`: R of Eq. 9; only stripes need it.
  /// @throws Error if the distance is not a number > 0
  PreparedModel(const Model& model, const Vector3<double>& wi, double detector_distance_m);

  /// BRDF in 1/sr, summed over all terms. NaN where the source or `ws` is not above the horizon (z <= 0), and for NaN
  /// in.
  double operator()(const Vector3<double>& ws) const;
  /// The same of term `i` alone, i < term_count(), in the model's order.
  double term(std::size_t i, const Vector3<double>& ws) const;
  std::size_t term_count() const { return terms_.size(); }

 private:
  struct PreparedLambertian {
    double per_sr;
  };
  using PreparedTerm = std::variant<PreparedMicrofacet, PreparedStripes, PreparedLambertian>;

  bool above_horizon(const Vector3<double>& ws) const;
  static double value(const PreparedTerm& term, const Vector3<double>& ws, const Vector3<double>& sum);

  Vector3<double> wi_;
  std::vector<PreparedTerm> terms_;
};

}  // namespace scatmap
