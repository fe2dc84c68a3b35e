#pragma once
#include <complex>
#include <string>
#include <vector>

#include "data-synthetic/vec3.h"

namespace scatmap::synth {

enum class TermKind { kMicrofacet, kStripes, kLambertian };
enum class Polarization { kUnpolarized, kS, kP };

/// One term of the BRDF (design, section 3) in the units of model.toml; the kind says which numbers it uses.
struct Term {
  TermKind kind = TermKind::kLambertian;
  double rho = 0;
  double m = 0;               ///< microfacet: slope parameter
  double n_re = 1, n_im = 0;  ///< microfacet: refractive index
  double dtheta_deg = 0, dphi_deg = 0;
  double a_um = 0, b_um = 0, c_um = 0;  ///< stripes: spacing, width, Gaussian width across the band
  bool grating = false;                 ///< stripes: form = "grating" instead of "paper"
};

struct ModelTruth {
  double wavelength_nm = 0;
  Polarization polarization = Polarization::kUnpolarized;
  double phi_ref_deg = 0;
  double distance_mm = 0;  ///< R of the stripes' Gaussian: the detector distance
  std::vector<Term> terms;
};

/// Squared moduli of the four Rayleigh–Rice factors; the first letter is the polarization in, the second out.
struct PolarizationFactors {
  long double ss = 0, sp = 0, ps = 0, pp = 0;
};

/// @param to_source, to_pixel unit vectors above the surface whose normal is z
PolarizationFactors polarization_factors(std::complex<long double> n, const Vec3& to_source, const Vec3& to_pixel);

/// BRDF in sr⁻¹; 0 for a microfacet term below its own tilted horizon. A factor whose exponent is below 1e-60 counts as
/// 0.
/// @param to_source, to_pixel unit vectors in sample axes, both above the surface
long double brdf_per_sr(const ModelTruth& model, const Vec3& to_source, const Vec3& to_pixel);
/// One term of it.
long double term_per_sr(const ModelTruth& model, const Term& term, const Vec3& to_source, const Vec3& to_pixel);

}  // namespace scatmap::synth
