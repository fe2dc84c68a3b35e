#include "scatmap/model/stripes.h"

#include <cmath>
#include <numbers>

#include "scatmap/model/exponent.h"

namespace scatmap {
namespace {

// sin(x)/x; the quotient itself is accurate everywhere else.
double sinc_of_phase(double phase_rad) { return phase_rad == 0 ? 1 : std::sin(phase_rad) / phase_rad; }

double square(double x) { return x * x; }

}  // namespace

PreparedStripes::PreparedStripes(const StripesTerm& term, double phi_ref_rad, double wavelength_m,
                                 double detector_distance_m, const Vector3<double>& wi)
    : form_(term.form),
      cos_phi_(std::cos(phi_ref_rad)),
      sin_phi_(std::sin(phi_ref_rad)),
      rho_per_sr_(term.rho),
      per_c2_(square(detector_distance_m / term.c_m)) {
  const double stretch = form_ == StripesForm::kPaper ? 2 * wi.z() : 1;
  period_phase_ = std::numbers::pi * term.a_m * stretch / wavelength_m;
  width_phase_ = std::numbers::pi * term.b_m * stretch / wavelength_m;
}

double PreparedStripes::operator()(const Vector3<double>& sum) const {
  const double along = cos_phi_ * sum.x() + sin_phi_ * sum.y();
  const double across = cos_phi_ * sum.y() - sin_phi_ * sum.x();
  const double length2 = sum.squaredNorm();
  const double exponent = -per_c2_ * along * along / length2;
  if (exponent < kExponentOfZero) return 0;
  const double y = form_ == StripesForm::kPaper ? across / std::sqrt(length2) : across;
  return rho_per_sr_ * square(std::cos(period_phase_ * y) * sinc_of_phase(width_phase_ * y)) * std::exp(exponent);
}

}  // namespace scatmap
