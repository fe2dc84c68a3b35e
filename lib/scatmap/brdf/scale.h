#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace scatmap {

/// How a cause may deviate from its stated value. Rectangular and triangular: within ±half width; asymmetric:
/// rectangular from −half_width_below to +half_width (GUM 4.3.8); normal: half width is one standard deviation.
enum class Distribution { kNormal, kRectangular, kTriangular, kAsymmetric };
const char* to_string(Distribution d);
/// The inverse of to_string; nullopt for a text it never gives.
std::optional<Distribution> distribution_from(const std::string& text);

/// A neutral-density filter: a physical object with a name. Exactly one statement of its uncertainty is given.
struct Filter {
  std::string name;
  double od = 0;  ///< optical density at the laser's wavelength
  Distribution distribution = Distribution::kRectangular;
  double half_width_od = 0;        ///< worst case; normal: one standard deviation
  double half_width_below_od = 0;  ///< asymmetric only: worst case towards smaller OD
};

/// A cause common to all pixels. Contribution to ln f: sensitivity × deviation of the cause.
struct ScaleCause {
  std::string name{};  ///< "filter od40", "laser drift", "exposure time (signature)"
  Distribution distribution = Distribution::kNormal;
  double half_width = 0;   ///< in the cause's unit: OD for filters, relative otherwise; 1 sigma when normal
  double sensitivity = 0;  ///< d ln f / d cause
  bool is_filter = false;
  double half_width_below = 0;  ///< asymmetric only
  double standard() const;      ///< |sensitivity| × standard uncertainty of the cause: relative
  double worst_case()
      const;  ///< |sensitivity| × half width (asymmetric: the larger); √3 standard uncertainties where normal
};

/// The interval that a relative factor 10^±δ spans: asymmetric.
struct ScaleInterval {
  double low = 0;   ///< 10^−δ − 1 (negative)
  double high = 0;  ///< 10^+δ − 1
};

/// Common to all pixels; never folded into a per-pixel number.
struct ScaleBudget {
  std::vector<ScaleCause> causes;
  Eigen::MatrixXd
      correlation;  ///< between the causes, in their order; empty: independent. Correlated causes are normal.

  /// Correlation of two causes: 1 of a cause with itself, 0 where nothing is known.
  double correlation_of(std::size_t a, std::size_t b) const;
  double standard() const;            ///< relative standard uncertainty, all causes, first order
  double filters_worst_case() const;  ///< ln10·sqrt(Σ (tol·OD)²): the paper's number
  double filters_standard() const;  ///< GUM standard uncertainty of the stack; worst case/√3 for rectangular tolerances
  double filters_linear_bound() const;     ///< ln10·Σ tol·OD: what no combination of tolerances can exceed
  ScaleInterval filters_interval() const;  ///< exact 10^±δ, δ = sqrt(Σ (tol·OD)²)
};

}  // namespace scatmap
