#include "scatmap/model/model.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "scatmap/base/error.h"

namespace scatmap {

PreparedModel::PreparedModel(const Model& model, const Vector3<double>& wi, double detector_distance_m) : wi_(wi) {
  if (!(detector_distance_m > 0 && std::isfinite(detector_distance_m))) {
    throw Error({"detector distance", "is out of range", std::to_string(detector_distance_m) + " m", "a number > 0"});
  }
  terms_.reserve(model.terms.size());
  for (const Term& term : model.terms) {
    if (const auto* microfacet = std::get_if<MicrofacetTerm>(&term)) {
      terms_.emplace_back(PreparedMicrofacet(*microfacet, model.phi_ref_rad, model.polarization, wi));
    } else if (const auto* stripes = std::get_if<StripesTerm>(&term)) {
      terms_.emplace_back(PreparedStripes(*stripes, model.phi_ref_rad, model.wavelength_m, detector_distance_m, wi));
    } else {
      terms_.emplace_back(PreparedLambertian{std::get<LambertianTerm>(term).rho / std::numbers::pi});
    }
  }
}

// A sum, so that a NaN in any component makes this false.
bool PreparedModel::above_horizon(const Vector3<double>& ws) const {
  const double transverse = wi_.x() + wi_.y() + ws.x() + ws.y();
  return wi_.z() > 0 && ws.z() > 0 && !std::isnan(transverse);
}

double PreparedModel::value(const PreparedTerm& term, const Vector3<double>& ws, const Vector3<double>& sum) {
  if (const auto* microfacet = std::get_if<PreparedMicrofacet>(&term)) return (*microfacet)(ws, sum);
  if (const auto* stripes = std::get_if<PreparedStripes>(&term)) return (*stripes)(sum);
  return std::get_if<PreparedLambertian>(&term)->per_sr;
}

double PreparedModel::operator()(const Vector3<double>& ws) const {
  if (!above_horizon(ws)) return std::numeric_limits<double>::quiet_NaN();
  const Vector3<double> sum = wi_ + ws;
  double total = 0;
  for (const PreparedTerm& term : terms_) total += value(term, ws, sum);
  return total;
}

double PreparedModel::term(std::size_t i, const Vector3<double>& ws) const {
  if (!above_horizon(ws)) return std::numeric_limits<double>::quiet_NaN();
  return value(terms_.at(i), ws, wi_ + ws);
}

}  // namespace scatmap
