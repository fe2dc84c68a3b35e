#pragma once
#include <complex>

#include "scatmap/base/direction.h"
#include "scatmap/model/polarization_q.h"

namespace scatmap {

/// A specular lobe with Gaussian slopes (paper, Eqs. 5, 6 and, with a tilted normal, 7 and 8).
struct MicrofacetTerm {
  double rho = 0;                ///< weight, >= 0
  double m = 0;                  ///< slope width, > 0: exp(−tan² theta_h / m²)
  std::complex<double> n = 1.0;  ///< refractive index nr + i k of the surface; nr > 0, k >= 0
  double dtheta_rad = 0;         ///< tilt of the facets' mean normal from the sample's
  double dphi_rad = 0;           ///< azimuth of that tilt, from +x (forward) towards +y, before phi_ref is added
};

/// From sample axes to axes whose z is the tilted normal: Ry(−dtheta) Rz(−dphi − phi_ref) (paper, Eq. 7).
Matrix3<double> facet_from_sample(double dtheta_rad, double azimuth_rad);

/// One microfacet term for one incident direction.
class PreparedMicrofacet {
 public:
  /// `wi`: unit vector towards the source, sample axes.
  PreparedMicrofacet(const MicrofacetTerm& term, double phi_ref_rad, Polarization polarization,
                     const Vector3<double>& wi);

  /// BRDF in 1/sr; `ws` unit, `sum` = wi + ws, both in sample axes. Exactly 0 where the exponential underflows, and
  /// where a tilted facet is lit or seen from behind: no light takes that path. NaN in, NaN out.
  /// s and p are counted against the facet's own plane of incidence, as Eq. 8 has it.
  double operator()(const Vector3<double>& ws, const Vector3<double>& sum) const;

 private:
  double lobe(const Vector3<double>& ws, const Vector3<double>& sum) const;

  bool tilted_;
  Matrix3<double> facet_from_sample_;
  Vector3<double> wi_;  // in the facet's axes
  PolarizationFactors polarization_;
  double per_m2_;
  double scale_per_sr_;  // rho / (2 pi m²)
};

}  // namespace scatmap
