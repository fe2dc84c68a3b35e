#pragma once
#include <string>
#include <vector>

namespace scatmap {

enum class Distribution { kNormal, kRectangular };
const char* to_string(Distribution d);

/// A neutral-density filter: a physical object with a name. Exactly one statement of its uncertainty is given.
struct Filter {
  std::string name;
  double od = 0;                                       ///< optical density at the laser's wavelength
  Distribution distribution = Distribution::kRectangular;
  double half_width_od = 0;                            ///< rectangular: worst case; normal: one standard deviation
};

/// A cause common to all pixels. Contribution to ln f: sensitivity × standard uncertainty.
struct ScaleCause {
  std::string name;              ///< "filter od40", "laser drift", "exposure time (signature)"
  Distribution distribution = Distribution::kNormal;
  double half_width = 0;         ///< in the cause's unit: OD for filters, relative otherwise; 1 sigma when normal
  double sensitivity = 0;        ///< d ln f / d cause
  bool is_filter = false;
  double standard() const;       ///< |sensitivity| × standard uncertainty of the cause: relative
  double worst_case() const;     ///< |sensitivity| × half width; √3 standard uncertainties where normal
};

/// The interval that a relative factor 10^±δ spans: asymmetric.
struct ScaleInterval {
  double low = 0;   ///< 10^−δ − 1 (negative)
  double high = 0;  ///< 10^+δ − 1
};

/// Common to all pixels; never folded into a per-pixel number.
struct ScaleBudget {
  std::vector<ScaleCause> causes;

  double standard() const;               ///< relative standard uncertainty, all causes, first order
  double filters_worst_case() const;     ///< ln10·sqrt(Σ (tol·OD)²): the paper's number
  double filters_standard() const;       ///< GUM standard uncertainty of the stack: the worst case / √3
  ScaleInterval filters_interval() const;  ///< exact 10^±δ, δ = sqrt(Σ (tol·OD)²)
};

}  // namespace scatmap
