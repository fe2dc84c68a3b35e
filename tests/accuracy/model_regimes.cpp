#include "accuracy/model_regimes.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "scatmap/base/units.h"

namespace scatmap::accuracy {
namespace {

using Random = std::mt19937_64;

double uniform(Random& r, double low, double high) { return std::uniform_real_distribution<double>(low, high)(r); }
double log_uniform(Random& r, double low, double high) { return std::exp(uniform(r, std::log(low), std::log(high))); }

Vector3<double> direction_deg(double theta_deg, double azimuth_deg) {
  const double t = theta_deg * kRadPerDeg, a = azimuth_deg * kRadPerDeg;
  return {std::sin(t) * std::cos(a), std::sin(t) * std::sin(a), std::cos(t)};
}

Vector3<double> specular(const Vector3<double>& wi) { return {-wi.x(), -wi.y(), wi.z()}; }

// A unit vector at about `offset` from v, above the horizon.
Vector3<double> beside(const Vector3<double>& v, double offset, Random& r) {
  const Vector3<double> first = v.unitOrthogonal(), second = v.cross(first);
  const double turn = uniform(r, 0, 7);
  Vector3<double> out = (v + offset * (std::cos(turn) * first + std::sin(turn) * second)).normalized();
  if (out.z() < 0.0175) out.z() = 0.0175;
  return out.normalized();
}

// theta_h at about `half_angle` from specular; grazing incidence stretches it in plane only.
Vector3<double> beside_specular(const Vector3<double>& wi, double half_angle, Random& r) {
  return beside(specular(wi), 2 * half_angle, r);
}

std::complex<double> any_index(Random& r) {
  return {uniform(r, 1.2, 4), uniform(r, 0, 1) < 0.5 ? 0.0 : log_uniform(r, 1e-6, 3)};
}

Polarization any_polarisation(Random& r) {
  const double u = uniform(r, 0, 3);
  return u < 1 ? Polarization::kUnpolarized : u < 2 ? Polarization::kS : Polarization::kP;
}

void fill(ModelCase& c, int directions, const std::function<Vector3<double>()>& next) {
  for (int i = 0; i < directions; ++i) c.ws.push_back(next());
}

ModelCase hemisphere(int directions, Random& r) {
  ModelCase c = empty_case(direction_deg(uniform(r, 0, 85), uniform(r, 0, 360)));
  for (int i = 0; i < 3; ++i) add_lobe(c, uniform(r, 0.1, 1), log_uniform(r, 0.1, 10), any_index(r));
  if (uniform(r, 0, 1) < 0.5) add_lambertian(c, uniform(r, 0, 0.5));
  fill(c, directions, [&] { return direction_deg(uniform(r, 0, 89), uniform(r, 0, 360)); });
  return c;
}

ModelCase peak(int directions, Random& r) {
  ModelCase c = empty_case(direction_deg(uniform(r, 0.5, 80), uniform(r, 0, 360)));
  add_lobe(c, 1, log_uniform(r, 1e-4, 1e-3), any_index(r));
  fill(c, directions, [&] { return beside_specular(c.wi, log_uniform(r, 1e-12, 1e-3), r); });
  return c;
}

ModelCase widths(int directions, Random& r) {
  ModelCase c = empty_case(direction_deg(uniform(r, 0.5, 80), uniform(r, 0, 360)));
  const double m = log_uniform(r, 1e-6, 10);
  add_lobe(c, 1, m, any_index(r));
  fill(c, directions, [&] { return beside_specular(c.wi, std::min(m, 0.3) * uniform(r, 0, 4), r); });
  return c;
}

ModelCase grazing(int directions, Random& r) {
  ModelCase c = empty_case(direction_deg(uniform(r, 85, 89), uniform(r, 0, 360)));
  add_lobe(c, 1, log_uniform(r, 1e-3, 1), any_index(r));
  const double azimuth = std::atan2(-c.wi.y(), -c.wi.x()) * kDegPerRad;
  fill(c, directions,
       [&] { return direction_deg(uniform(r, 85, 89), azimuth + uniform(r, -1, 1) * log_uniform(r, 1e-3, 180)); });
  return c;
}

ModelCase faint_surface(int directions, Random& r) {
  ModelCase c = empty_case(direction_deg(uniform(r, 0, 85), uniform(r, 0, 360)));
  add_lobe(c, 1, log_uniform(r, 1e-3, 3), {1 + log_uniform(r, 1e-6, 0.1), 0});
  add_lobe(c, 1, log_uniform(r, 1e-3, 3), {1 + log_uniform(r, 1e-6, 0.1), log_uniform(r, 1e-9, 1e-2)});
  fill(c, directions, [&] { return direction_deg(uniform(r, 0, 89), uniform(r, 0, 360)); });
  return c;
}

ModelCase metals(int directions, Random& r) {
  ModelCase c = empty_case(direction_deg(uniform(r, 0, 85), uniform(r, 0, 360)));
  for (int i = 0; i < 2; ++i)
    add_lobe(c, 1, log_uniform(r, 1e-2, 1), {log_uniform(r, 0.02, 1.5), log_uniform(r, 2, 100)});
  fill(c, directions, [&] { return beside_specular(c.wi, uniform(r, 0, 0.5), r); });
  return c;
}

ModelCase total(int directions, Random& r) {
  const double n = uniform(r, 0.5, 0.99);
  ModelCase c = empty_case(direction_deg(uniform(r, 0, 85), uniform(r, 0, 360)));
  add_lobe(c, 1, log_uniform(r, 0.05, 1), {n, uniform(r, 0, 1) < 0.5 ? 0.0 : log_uniform(r, 1e-9, 1e-3)});
  fill(c, directions, [&] {
    for (;;) {
      const Vector3<double> ws = direction_deg(uniform(r, 0, 89), uniform(r, 0, 360));
      if (std::abs((n - 1) * (n + 1) + ws.z() * ws.z()) > 1e-6) return ws;
    }
  });
  return c;
}

ModelCase normal(int directions, Random& r) {
  const double theta_deg = uniform(r, 0, 1) < 0.3 ? 0 : log_uniform(r, 1e-14, 0.06);
  // Along the normal polarised light has no plane of incidence: which one is taken instead is a matter of definition.
  ModelCase c = empty_case(direction_deg(theta_deg, uniform(r, 0, 360)), 0,
                           theta_deg == 0 ? Polarization::kUnpolarized : any_polarisation(r));
  add_lobe(c, 1, log_uniform(r, 1e-4, 1), any_index(r));
  fill(c, directions, [&] { return direction_deg(log_uniform(r, 1e-14, 0.06), uniform(r, 0, 360)); });
  c.ws.front() = {0, 0, 1};
  return c;
}

ModelCase tilted(int directions, Random& r) {
  ModelCase c =
      empty_case(direction_deg(uniform(r, 0, 70), uniform(r, 0, 360)), uniform(r, -360, 360), any_polarisation(r));
  const double m = log_uniform(r, 1e-5, 1), dtheta = uniform(r, 0.01, 10), dphi = uniform(r, -360, 360);
  add_lobe(c, 1, m, any_index(r), dtheta, dphi);
  const Vector3<double> n = direction_deg(dtheta, dphi + c.truth.phi_ref_deg);
  const Vector3<double> mirrored = 2 * n.dot(c.wi) * n - c.wi;
  fill(c, directions, [&] { return beside(mirrored, 2 * std::min(m, 0.3) * uniform(r, 0, 4), r); });
  return c;
}

ModelCase polarised(int directions, Random& r) {
  ModelCase c = empty_case(direction_deg(uniform(r, 0, 85), uniform(r, 0, 360)), 0,
                           uniform(r, 0, 1) < 0.5 ? Polarization::kS : Polarization::kP);
  add_lobe(c, 1, log_uniform(r, 0.05, 1), any_index(r));
  fill(c, directions, [&] { return direction_deg(uniform(r, 0, 88), uniform(r, 0, 360)); });
  return c;
}

ModelCase stripes(int directions, Random& r) {
  ModelCase c = empty_case(direction_deg(uniform(r, 0, 80), 180), uniform(r, -360, 360));
  const double a_um = log_uniform(r, 1, 1e9), spread = uniform(r, 0.01, 1);
  add_stripes(c, 300, a_um, a_um * log_uniform(r, 1e-3, 1), 325e3 * log_uniform(r, 1e-4, 10),
              uniform(r, 0, 1) < 0.5 ? StripesForm::kPaper : StripesForm::kGrating);
  fill(c, directions, [&] { return beside(specular(c.wi), spread * log_uniform(r, 1e-9, 1), r); });
  return c;
}

ModelCase paper(int directions, Random& r) {
  const double theta_deg = uniform(r, 5, 70);
  ModelCase c = empty_case(direction_deg(theta_deg, 180), uniform(r, 0, 1) < 0.5 ? 0 : uniform(r, 0, 360));
  add_lobe(c, 0.7, 2e-4, {1.4, 0}, 0.5, 45);
  add_lobe(c, 0.015, 2e-4, {3.6, 0});
  add_stripes(c, 300, 800, 10, 40, StripesForm::kPaper);
  fill(c, directions, [&] { return beside(specular(c.wi), 0.025 * log_uniform(r, 1e-5, 1), r); });
  return c;
}

}  // namespace

ModelCase empty_case(const Vector3<double>& wi, double phi_ref_deg, Polarization polarization) {
  ModelCase c;
  c.wi = wi;
  c.model.wavelength_m = 632.8 * kMetrePerNm;
  c.model.polarization = polarization;
  c.model.phi_ref_rad = phi_ref_deg * kRadPerDeg;
  c.truth.wavelength_nm = 632.8;
  c.truth.polarization = polarization == Polarization::kUnpolarized ? synth::Polarization::kUnpolarized
                         : polarization == Polarization::kS         ? synth::Polarization::kS
                                                                    : synth::Polarization::kP;
  c.truth.phi_ref_deg = phi_ref_deg;
  c.truth.distance_mm = kDistance_mm;
  return c;
}

void add_lobe(ModelCase& c, double rho, double m, std::complex<double> n, double dtheta_deg, double dphi_deg) {
  c.model.terms.push_back(MicrofacetTerm{rho, m, n, dtheta_deg * kRadPerDeg, dphi_deg * kRadPerDeg});
  synth::Term t;
  t.kind = synth::TermKind::kMicrofacet;
  t.rho = rho;
  t.m = m;
  t.n_re = n.real();
  t.n_im = n.imag();
  t.dtheta_deg = dtheta_deg;
  t.dphi_deg = dphi_deg;
  c.truth.terms.push_back(t);
  c.sensitive |= dtheta_deg != 0;
}

void add_stripes(ModelCase& c, double rho, double a_um, double b_um, double c_um, StripesForm form) {
  c.model.terms.push_back(StripesTerm{rho, a_um * kMetrePerUm, b_um * kMetrePerUm, c_um * kMetrePerUm, form});
  synth::Term t;
  t.kind = synth::TermKind::kStripes;
  t.rho = rho;
  t.a_um = a_um;
  t.b_um = b_um;
  t.c_um = c_um;
  t.grating = form == StripesForm::kGrating;
  c.truth.terms.push_back(t);
  c.sensitive = true;
}

void add_lambertian(ModelCase& c, double rho) {
  c.model.terms.push_back(LambertianTerm{rho});
  synth::Term t;
  t.rho = rho;
  c.truth.terms.push_back(t);
}

long double truth_at(const ModelCase& c, const Vector3<long double>& ws) {
  return synth::brdf_per_sr(c.truth, {c.wi.x(), c.wi.y(), c.wi.z()}, {ws.x(), ws.y(), ws.z()});
}

const char* regime_name(Regime regime) {
  static constexpr const char* kNames[kRegimeCount] = {"hemisphere", "peak",      "widths",  "grazing",
                                                       "faint",      "metals",    "total",   "normal",
                                                       "tilted",     "polarised", "stripes", "paper"};
  return kNames[static_cast<int>(regime)];
}

ModelCase model_case(Regime regime, int directions, std::mt19937_64& random) {
  static constexpr ModelCase (*kMake[kRegimeCount])(int, Random&) = {
      hemisphere, peak, widths, grazing, faint_surface, metals, total, normal, tilted, polarised, stripes, paper};
  ModelCase c = kMake[static_cast<int>(regime)](directions, random);
  for (const Vector3<double>& ws : c.ws) {
    c.truth_per_sr.push_back(truth_at(c, ws.cast<long double>()));
    c.peak_per_sr = std::max(c.peak_per_sr, c.truth_per_sr.back());
  }
  return c;
}

}  // namespace scatmap::accuracy
