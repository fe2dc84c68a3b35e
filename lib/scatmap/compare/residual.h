#pragma once
#include <optional>

#include "scatmap/brdf/brdf_map.h"

namespace scatmap {

/// Sum of squared normalised residuals. Its expectation is `degrees_of_freedom` when the model is true. The spread is
/// sqrt(2 · degrees_of_freedom) only where random uncertainty rules: pixels share their structured causes.
struct ChiSquared {
  double sum = 0;
  double degrees_of_freedom = 0;
  double per_degree() const { return sum / degrees_of_freedom; }
};

/// The common factor s of measured ≈ s · modelled, by least squares weighted with 1/u².
struct ScaleFit {
  double factor = 1;
  double standard_error = 0;   ///< from the random uncertainties alone
  double u_scale = 0;          ///< relative standard uncertainty of the two maps' scales together
  std::optional<double> pull;  ///< |factor − 1| / u_scale; absent if neither map states a scale uncertainty
};

/// Measured against modelled, pixel by pixel. u² = random² + pose² + Σ structured² of both maps; scale is kept out of
/// it.
struct Residual {
  Grid<float> normalised;  ///< (measured − modelled) / u; NaN where a pixel is not used
  std::size_t pixels = 0;  ///< used: both masks 0, both values finite, u > 0
  ChiSquared as_is;        ///< scale fixed at 1
  ChiSquared scaled;       ///< scale free: one degree of freedom less
  ScaleFit scale;
};

/// @throws Error if neither map has uncertainties, the shapes differ or fewer than two pixels can be used
Residual residual(const BrdfMap& measured, const BrdfMap& modelled);

/// log10(measured / modelled), for viewing; NaN where a mask is set or a value is not positive. Same shapes.
Grid<float> log10_ratio(const BrdfMap& measured, const BrdfMap& modelled);

}  // namespace scatmap
