#include "scatmap/model/microfacet.h"

#include <cmath>
#include <numbers>

#include "scatmap/base/rotation.h"
#include "scatmap/model/exponent.h"

namespace scatmap {

Matrix3<double> facet_from_sample(double dtheta_rad, double azimuth_rad) {
  return rotation_y(-dtheta_rad) * rotation_z(-azimuth_rad);
}

PreparedMicrofacet::PreparedMicrofacet(const MicrofacetTerm& term, double phi_ref_rad, Polarization polarization,
                                       const Vector3<double>& wi)
    : tilted_(term.dtheta_rad != 0),
      facet_from_sample_(facet_from_sample(term.dtheta_rad, term.dphi_rad + phi_ref_rad)),
      wi_(tilted_ ? facet_from_sample_ * wi : wi),
      polarization_(term.n, wi_, polarization),
      per_m2_(1 / (term.m * term.m)),
      scale_per_sr_(term.rho / (2 * std::numbers::pi * term.m * term.m)) {}

double PreparedMicrofacet::operator()(const Vector3<double>& ws, const Vector3<double>& sum) const {
  if (!tilted_) return lobe(ws, sum);
  // The sum is rotated as a whole: near specular its transverse part is small and must not be made from large numbers.
  return lobe(facet_from_sample_ * ws, facet_from_sample_ * sum);
}

double PreparedMicrofacet::lobe(const Vector3<double>& ws, const Vector3<double>& sum) const {
  if (wi_.z() <= 0 || ws.z() <= 0) return 0;
  const double per_z2 = 1 / (sum.z() * sum.z());  // sum.z = cos theta_i + cos theta_s
  const double tan2_h = (sum.x() * sum.x() + sum.y() * sum.y()) * per_z2;
  const double exponent = -tan2_h * per_m2_;
  if (exponent < kExponentOfZero) return 0;
  const double per_cos2_h = 1 + tan2_h;
  return scale_per_sr_ * polarization_.q(ws) * per_z2 * per_cos2_h * per_cos2_h * std::exp(exponent);
}

}  // namespace scatmap
