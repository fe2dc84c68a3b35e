#include "tools/chart/naive_model.h"

#include <cmath>
#include <complex>
#include <numbers>

namespace scatmap::tools {
namespace {

using Complex = std::complex<double>;
using V = Vector3<double>;
constexpr double kPi = std::numbers::pi;

struct Angles {
  double theta, phi;
};

Angles angles_of(const V& v) { return {std::acos(v.z()), std::atan2(v.y(), v.x())}; }

double q_of(Complex n, const Angles& i, const Angles& s, Polarization laser) {
  const Complex e = n * n;
  const double ci = std::cos(i.theta), cs = std::cos(s.theta), si = std::sin(i.theta), ss = std::sin(s.theta);
  const double delta = s.phi - i.phi - kPi;
  const Complex gi = std::sqrt(e - si * si), gs = std::sqrt(e - ss * ss);
  const Complex q_ss = (e - 1.0) * std::cos(delta) / ((ci + gi) * (cs + gs));
  const Complex q_sp = -(e - 1.0) * gs * std::sin(delta) / ((ci + gi) * (e * cs + gs));
  const Complex q_ps = -(e - 1.0) * gi * std::sin(delta) / ((e * ci + gi) * (cs + gs));
  const Complex q_pp = (e - 1.0) * (e * si * ss - gi * gs * std::cos(delta)) / ((e * ci + gi) * (e * cs + gs));
  const double s_in = std::norm(q_ss) + std::norm(q_sp), p_in = std::norm(q_pp) + std::norm(q_ps);
  if (laser == Polarization::kUnpolarized) return s_in + p_in;
  return 2 * (laser == Polarization::kS ? s_in : p_in);
}

double microfacet(const MicrofacetTerm& t, const Model& model, V wi, V ws) {
  if (t.dtheta_rad != 0) {
    const double azimuth = t.dphi_rad + model.phi_ref_rad;
    const Matrix3<double> turn =
        (Eigen::AngleAxisd(-t.dtheta_rad, V::UnitY()) * Eigen::AngleAxisd(-azimuth, V::UnitZ())).toRotationMatrix();
    wi = turn * wi;
    ws = turn * ws;
  }
  if (wi.z() <= 0 || ws.z() <= 0) return 0;
  const Angles i = angles_of(wi), s = angles_of(ws), h = angles_of((wi + ws).normalized());
  const double cosines = std::cos(i.theta) + std::cos(s.theta), slope = std::tan(h.theta) / t.m;
  return t.rho * q_of(t.n, i, s, model.polarization) / (2 * cosines * cosines) * std::exp(-slope * slope) /
         (kPi * t.m * t.m * std::pow(std::cos(h.theta), 4));
}

double stripes(const StripesTerm& t, const Model& model, double distance_m, const V& wi, const V& ws) {
  const V h = (wi + ws).normalized();
  const Angles a = angles_of(h);
  const double x = std::sin(a.theta) * std::cos(a.phi - model.phi_ref_rad);
  const double y = std::sin(a.theta) * std::sin(a.phi - model.phi_ref_rad);
  const double waves =
      (t.form == StripesForm::kPaper ? 2 * std::cos(angles_of(wi).theta) : (wi + ws).norm()) * y / model.wavelength_m;
  const double width = kPi * t.b_m * waves, sinc = width == 0 ? 1 : std::sin(width) / width;
  const double cosine = std::cos(kPi * t.a_m * waves), along = distance_m * x / t.c_m;
  return t.rho * cosine * cosine * sinc * sinc * std::exp(-along * along);
}

}  // namespace

double naive_model(const Model& model, const SampleView& view, double detector_distance_m, int column, int row) {
  const V ws = view.pixel(column, row).normalized();
  double sum = 0;
  for (const Term& term : model.terms) {
    if (const auto* lobe = std::get_if<MicrofacetTerm>(&term)) {
      sum += microfacet(*lobe, model, view.to_source, ws);
    } else if (const auto* pattern = std::get_if<StripesTerm>(&term)) {
      sum += stripes(*pattern, model, detector_distance_m, view.to_source, ws);
    } else {
      sum += std::get<LambertianTerm>(term).rho / kPi;
    }
  }
  return sum;
}

}  // namespace scatmap::tools
