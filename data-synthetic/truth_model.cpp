#include "data-synthetic/truth_model.h"

#include <cmath>

namespace scatmap::synth {
namespace {

// exp(−138.2) = 1e-60: beyond it a term is not worth its cosines.
constexpr long double kLargestExponent = 138.2L;

long double squared(long double v) { return v * v; }

// The polarization average of Eq. (5): Q/2 unpolarized, one incident state's share otherwise.
long double reflected(const PolarizationFactors& q, Polarization polarization) {
  switch (polarization) {
    case Polarization::kS:
      return q.ss + q.sp;
    case Polarization::kP:
      return q.pp + q.ps;
    case Polarization::kUnpolarized:
      break;
  }
  return (q.ss + q.sp + q.ps + q.pp) / 2;
}

long double microfacet(const ModelTruth& model, const Term& term, const Vec3& to_source, const Vec3& to_pixel) {
  const auto tilted = [&](const Vec3& v) {
    const long double azimuth_deg = static_cast<long double>(term.dphi_deg) + model.phi_ref_deg;
    return turn_y(turn_z(v, -azimuth_deg), -static_cast<long double>(term.dtheta_deg));
  };
  const bool flat = term.dtheta_deg == 0;
  const Vec3 wi = flat ? to_source : tilted(to_source);
  const Vec3 ws = flat ? to_pixel : tilted(to_pixel);
  if (!(wi.z > 0 && ws.z > 0)) return 0;
  const Vec3 h = wi + ws;
  const long double m2 = squared(term.m);
  const long double tan2 = (h.x * h.x + h.y * h.y) / (h.z * h.z);
  if (tan2 > kLargestExponent * m2) return 0;
  // 1/cos⁴θh = (1 + tan²θh)².
  const long double facets = std::exp(-tan2 / m2) * squared(1 + tan2) / (kPi * m2);
  const PolarizationFactors q = polarization_factors({term.n_re, term.n_im}, wi, ws);
  return term.rho * reflected(q, model.polarization) / squared(wi.z + ws.z) * facets;
}

long double sinc(long double x) { return x == 0 ? 1 : std::sin(kPi * x) / (kPi * x); }

long double stripes(const ModelTruth& model, const Term& term, const Vec3& to_source, const Vec3& to_pixel) {
  const Vec3 sum = to_source + to_pixel;
  const Vec3 turned = turn_z(sum, -static_cast<long double>(model.phi_ref_deg));
  const Vec3 h = (1 / length(sum)) * turned;
  const long double along = 1000.0L * model.distance_mm * h.x / term.c_um;
  if (along * along > kLargestExponent) return 0;
  // In orders of a slit pair of unit spacing: Eq. (9)'s 2ȳ cosθi/λ, or the grating equation's own (ωi + ωs)·ȳ/λ.
  const long double per_um = 1000 * (term.grating ? turned.y : 2 * h.y * to_source.z) / model.wavelength_nm;
  return term.rho * squared(std::cos(kPi * term.a_um * per_um) * sinc(term.b_um * per_um)) * std::exp(-along * along);
}

}  // namespace

PolarizationFactors polarization_factors(std::complex<long double> n, const Vec3& to_source, const Vec3& to_pixel) {
  using Complex = std::complex<long double>;
  const long double ci = to_source.z, cs = to_pixel.z;
  const long double si = std::hypot(to_source.x, to_source.y), ss = std::hypot(to_pixel.x, to_pixel.y);
  // Forward, azimuth difference 0, is where the pixel lies opposite to the source; free to choose at a pole.
  const bool pole = si == 0 || ss == 0;
  const long double forward = -(to_source.x * to_pixel.x + to_source.y * to_pixel.y);
  const long double sideways = to_source.y * to_pixel.x - to_source.x * to_pixel.y;
  const long double cosine = pole ? 1 : forward / (si * ss), sine = pole ? 0 : sideways / (si * ss);

  const Complex e = n * n;
  const Complex gi = std::sqrt(e - si * si), gs = std::sqrt(e - ss * ss);
  const Complex in_s = ci + gi, in_p = e * ci + gi, out_s = cs + gs, out_p = e * cs + gs;
  const Complex ss_factor = (e - 1.0L) * cosine / (in_s * out_s);
  const Complex sp_factor = (e - 1.0L) * gs * sine / (in_s * out_p);
  const Complex ps_factor = (e - 1.0L) * gi * sine / (in_p * out_s);
  const Complex pp_factor = (e - 1.0L) * (e * si * ss - gi * gs * cosine) / (in_p * out_p);
  return {std::norm(ss_factor), std::norm(sp_factor), std::norm(ps_factor), std::norm(pp_factor)};
}

long double term_per_sr(const ModelTruth& model, const Term& term, const Vec3& to_source, const Vec3& to_pixel) {
  if (term.rho == 0) return 0;
  switch (term.kind) {
    case TermKind::kMicrofacet:
      return microfacet(model, term, to_source, to_pixel);
    case TermKind::kStripes:
      return stripes(model, term, to_source, to_pixel);
    case TermKind::kLambertian:
      break;
  }
  return term.rho / kPi;
}

long double brdf_per_sr(const ModelTruth& model, const Vec3& to_source, const Vec3& to_pixel) {
  long double sum = 0;
  for (const Term& term : model.terms) sum += term_per_sr(model, term, to_source, to_pixel);
  return sum;
}

}  // namespace scatmap::synth
