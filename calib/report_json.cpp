#include <cmath>
#include <nlohmann/json.hpp>

#include "calib/report.h"
#include "scatmap/base/provenance.h"
#include "scatmap/base/units.h"

namespace scatmap::calib {
namespace {

using nlohmann::json;

json number(double v) { return std::isfinite(v) ? json(v) : json(nullptr); }
json pair(const Eigen::Vector2d& v) { return {number(v[0]), number(v[1])}; }

json directions_json(const CalibrationResult& r) {
  json out = json::array();
  for (const DirectionSigma& d : r.directions) {
    out.push_back({{"where", d.point.where},
                   {"column_px", d.point.column_px},
                   {"row_px", d.point.row_px},
                   {"stage_deg", d.point.pose.stage_rad * kDegPerRad},
                   {"arm_deg", d.point.pose.arm_rad * kDegPerRad},
                   {"sigma_mrad", d.rad * 1e3},
                   {"sigma_deg", d.rad * kDegPerRad},
                   {"sigma_column_px", d.column_px},
                   {"sigma_row_px", d.row_px}});
  }
  return out;
}

json parameters_json(const CalibrationResult& r) {
  json out = json::array();
  for (const ParameterResult& p : r.parameters) {
    json one{{"name", p.name}, {"nominal", p.nominal}, {"value", p.value}, {"outcome", to_string(p.outcome)}};
    if (p.outcome != Outcome::kHeld) one["sigma"] = p.sigma;
    if (p.prior_sigma) one["prior_sigma"] = *p.prior_sigma;
    if (p.outcome == Outcome::kLeftOut) one["bound_px"] = p.bound_px;
    out.push_back(one);
  }
  return out;
}

json correlation_json(const CalibrationResult& r) {
  json names = json::array(), rows = json::array();
  for (const Fitted& f : r.set) names.push_back(r.parameters[static_cast<std::size_t>(f.index)].name);
  for (Eigen::Index a = 0; a < r.covariance.rows(); ++a) {
    json row = json::array();
    for (Eigen::Index b = 0; b < r.covariance.cols(); ++b)
      row.push_back(r.covariance(a, b) / std::sqrt(r.covariance(a, a) * r.covariance(b, b)));
    rows.push_back(row);
  }
  return {{"parameters", names}, {"matrix", rows}};
}

json targets_json(const TargetList& list, const CalibrationResult& r) {
  json out = json::array();
  for (std::size_t i = 0; i < r.targets.size(); ++i) {
    const TargetResult& t = r.targets[i];
    json one{{"line", list.targets[i].line},
             {"used", t.used},
             {"residual_px", pair(t.residual_px)},
             {"sigma_px", pair(t.sigma_px)},
             {"distance_sigma", number(t.distance)}};
    if (!list.targets[i].file.empty()) one["file"] = utf8_text(list.targets[i].file);
    if (t.left_out_px) one["left_out_residual_px"] = pair(*t.left_out_px);
    out.push_back(one);
  }
  return out;
}

json observability_json(const Observability& o) {
  json out{{"singular_values", json::array()}, {"blind", json::array()}};
  for (const double v : o.singular_values) out["singular_values"].push_back(v);
  for (const BlindDirection& b : o.blind) {
    out["blind"].push_back({{"parameters", b.parameters},
                            {"singular_value", b.singular_value},
                            {"effect_px", b.effect_px},
                            {"remedy", b.remedy.empty() ? json(nullptr) : json(b.remedy)},
                            {"sentence", sentence(b)}});
  }
  return out;
}

}  // namespace

std::string report_json(const TargetList& list, const CalibrationResult& r) {
  json out{{"directions", directions_json(r)},
           {"findings", r.findings},
           {"parameters", parameters_json(r)},
           {"correlation", correlation_json(r)},
           {"observability", observability_json(r.observability)},
           {"targets", targets_json(list, r)}};
  for (const ChiSquare& c : r.chi2) {
    out["chi_square"].push_back({{"part", c.part},
                                 {"value", c.value},
                                 {"degrees_of_freedom", c.degrees},
                                 {"reduced", c.degrees > 1e-6 ? number(c.value / c.degrees) : json(nullptr)}});
  }
  out["leave_one_out_rms_sigma"] = number(r.left_out_rms);
  out["condition"] = number(r.condition);
  out["iterations"] = r.iterations;
  out["converged"] = r.converged;
  return out.dump(2);
}

}  // namespace scatmap::calib
