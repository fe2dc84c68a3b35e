#pragma once
#include <cmath>

#include "scatmap/base/units.h"
#include "scatmap/model/model.h"

namespace scatmap::test {

/// The paper's scene (Sec. 4.4.1), with the two numbers it does not print correctly or at all: the detector stands
/// 0.325 m away (it says cm), and its sensor is 13.5 mm high (from the 26 maxima between centre and edge).
inline constexpr double kDistance_m = 0.325;
inline constexpr double kHalfHeight_m = 6.75e-3;

inline MicrofacetTerm centre_term() { return {0.015, 2e-4, 3.6, 0, 0}; }
inline MicrofacetTerm offset_term() { return {0.7, 2e-4, 1.4, 0.5 * kRadPerDeg, 45 * kRadPerDeg}; }
inline StripesTerm stripes_term() { return {300, 8e-4, 1e-5, 4e-5, StripesForm::kPaper}; }

inline Model one_term(const Term& term, double phi_ref_deg = 0) {
  return {632.8e-9, Polarization::kUnpolarized, phi_ref_deg * kRadPerDeg, {term}};
}

inline Model paper_model(double phi_ref_deg = 0) {
  Model model = one_term(centre_term(), phi_ref_deg);
  model.terms.push_back(offset_term());
  model.terms.push_back(stripes_term());
  return model;
}

/// Unit direction at polar angle theta and azimuth from +x (forward) towards +y, degrees.
inline Vector3<double> direction_deg(double theta_deg, double azimuth_deg) {
  const double t = theta_deg * kRadPerDeg, a = azimuth_deg * kRadPerDeg;
  return {std::sin(t) * std::cos(a), std::sin(t) * std::sin(a), std::cos(t)};
}

/// Towards the source, in the paper's convention: at −x.
inline Vector3<double> source_deg(double theta_deg) {
  return {-std::sin(theta_deg * kRadPerDeg), 0, std::cos(theta_deg * kRadPerDeg)};
}

/// Direction of the point `right_m` (away from the normal) and `down_m` (+y) from the middle of a sensor that faces the
/// sample in the specular direction.
inline Vector3<double> sensor_direction(double theta_i_deg, double right_m, double down_m) {
  const double t = theta_i_deg * kRadPerDeg;
  const Vector3<double> boresight(std::sin(t), 0, std::cos(t)), right(std::cos(t), 0, -std::sin(t));
  return (kDistance_m * boresight + right_m * right + down_m * Vector3<double>::UnitY()).normalized();
}

}  // namespace scatmap::test
