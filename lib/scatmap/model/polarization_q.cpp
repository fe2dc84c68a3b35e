#include "scatmap/model/polarization_q.h"

#include <cmath>

namespace scatmap {
namespace {

using Complex = std::complex<double>;

// Below this sin², the squares of the components underflow and the azimuth is noise.
constexpr double kSmallestSin2 = 1e-290;

// Principal root of a number with imaginary part >= 0; several times as fast as std::sqrt.
Complex sqrt_upper(const Complex& z) {
  const double a = z.real(), b = z.imag();
  if (b == 0) return a < 0 ? Complex(0, std::sqrt(-a)) : Complex(std::sqrt(a), 0);
  const double major = std::sqrt((std::sqrt(a * a + b * b) + std::abs(a)) / 2);
  const double minor = b / (2 * major);
  return a < 0 ? Complex(minor, major) : Complex(major, minor);
}

double incident_weight(Polarization laser, Polarization component) {
  if (laser == Polarization::kUnpolarized) return 1;
  return laser == component ? 2 : 0;
}

}  // namespace

// Numerators without e − 1, and the factors of the denominators that depend on the scattered direction.
struct PolarizationFactors::Parts {
  double ss;
  Complex sp, ps, pp;
  Complex s_out, p_out;
};

PolarizationFactors::PolarizationFactors(Complex n, const Vector3<double>& wi, Polarization polarization)
    : contrast_((n - 1.0) * (n + 1.0)) {
  const double c = wi.z(), sin2 = wi.x() * wi.x() + wi.y() * wi.y();
  const double s = std::sqrt(sin2);
  const bool along_normal = sin2 < kSmallestSin2;
  const Complex e = n * n;
  e_sin_i_ = along_normal ? 0 : e * s;
  g_i_ = sqrt_upper(contrast_ + c * c);
  s_in_ = c + g_i_;
  p_in_ = e * c + g_i_;
  forward_x_ = along_normal ? 1 : -wi.x() / s;
  forward_y_ = along_normal ? 0 : -wi.y() / s;
  s_weight_ = incident_weight(polarization, Polarization::kS) * std::norm(contrast_) / std::norm(s_in_);
  p_weight_ = incident_weight(polarization, Polarization::kP) * std::norm(contrast_) / std::norm(p_in_);
}

PolarizationFactors::Parts PolarizationFactors::parts(const Vector3<double>& ws) const {
  const double c = ws.z(), sin2 = ws.x() * ws.x() + ws.y() * ws.y();
  const bool along_normal = sin2 < kSmallestSin2;
  const double s = std::sqrt(sin2);
  const double cos_azimuth = along_normal ? 1 : (forward_x_ * ws.x() + forward_y_ * ws.y()) / s;
  const double sin_azimuth = along_normal ? 0 : (forward_x_ * ws.y() - forward_y_ * ws.x()) / s;
  const Complex g = sqrt_upper(contrast_ + c * c);  // sqrt(e − sin²), without the detour over sin²
  return {cos_azimuth, -g * sin_azimuth,         -g_i_ * sin_azimuth, e_sin_i_ * s - g_i_ * g * cos_azimuth,
          c + g,       (contrast_ + 1.0) * c + g};
}

PolarizationQ PolarizationFactors::amplitudes(const Vector3<double>& ws) const {
  const Parts p = parts(ws);
  return {contrast_ * p.ss / (s_in_ * p.s_out), contrast_ * p.sp / (s_in_ * p.p_out),
          contrast_ * p.ps / (p_in_ * p.s_out), contrast_ * p.pp / (p_in_ * p.p_out)};
}

double PolarizationFactors::q(const Vector3<double>& ws) const {
  const Parts p = parts(ws);
  const double s_out = 1 / std::norm(p.s_out), p_out = 1 / std::norm(p.p_out);
  return s_weight_ * (p.ss * p.ss * s_out + std::norm(p.sp) * p_out) +
         p_weight_ * (std::norm(p.ps) * s_out + std::norm(p.pp) * p_out);
}

PolarizationQ polarization_amplitudes(Complex n, const Vector3<double>& wi, const Vector3<double>& ws) {
  return PolarizationFactors(n, wi, Polarization::kUnpolarized).amplitudes(ws);
}

double polarization_q(Complex n, const Vector3<double>& wi, const Vector3<double>& ws, Polarization polarization) {
  return PolarizationFactors(n, wi, polarization).q(ws);
}

}  // namespace scatmap
