#include "scatmap/report/comparison_text.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace scatmap {
namespace {

using nlohmann::json;

json number(double v) { return std::isfinite(v) ? json(v) : json(nullptr); }

json peak_json(const Peak& p) {
  return {{"column_px", number(p.column_px)},
          {"row_px", number(p.row_px)},
          {"column_sigma_px", number(p.column_sigma_px)},
          {"row_sigma_px", number(p.row_sigma_px)},
          {"height_per_sr", number(p.height_per_sr)},
          {"height_sigma_per_sr", number(p.height_sigma_per_sr)},
          {"radius_px", number(p.radius_px)},
          {"minor_radius_px", number(p.minor_radius_px)},
          {"theta_s_deg", number(p.theta_s_deg)},
          {"phi_s_deg", number(p.phi_s_deg)},
          {"prominence", number(p.prominence)}};
}

json comb_json(const std::optional<FringeComb>& comb) {
  if (!comb) return nullptr;
  json maxima = json::array();
  for (const FringeMaximum& m : comb->maxima) {
    maxima.push_back({{"order", m.order},
                      {"offset_px", number(m.offset_px)},
                      {"angle_deg", number(m.angle_deg)},
                      {"height_per_sr", number(m.height_per_sr)},
                      {"clear", m.clear}});
  }
  return {{"orders_before", comb->orders_before},
          {"orders_after", comb->orders_after},
          {"spacing_px", number(comb->spacing_px)},
          {"spacing_sigma_px", number(comb->spacing_sigma_px)},
          {"spacing_deg", number(comb->spacing_deg)},
          {"spacing_sigma_deg", number(comb->spacing_sigma_deg)},
          {"first_height_per_sr", number(comb->first_height_per_sr)},
          {"last_height_per_sr", number(comb->last_height_per_sr)},
          {"maxima", maxima}};
}

json features_json(const MapFeatures& f) {
  json out{{"peaks", json::array()}};
  for (const Peak& p : f.peaks) out["peaks"].push_back(peak_json(p));
  out["band"] = nullptr;
  if (f.band)
    out["band"] = {{"axis_deg", number(f.band->axis_deg)},
                   {"direction_deg", number(f.band->direction_deg)},
                   {"radius_px", number(f.band->radius_px)}};
  out["fringes_along_ridge"] = comb_json(f.along_ridge);
  out["fringes_along_column"] = comb_json(f.along_column);
  return out;
}

json residual_json(const std::optional<Residual>& r) {
  if (!r) return nullptr;
  json out{{"pixels", r->pixels},
           {"reduced_chi2", number(r->as_is.per_degree())},
           {"reduced_chi2_scale_free", number(r->scaled.per_degree())},
           {"scale_factor", number(r->scale.factor)},
           {"scale_factor_standard_error", number(r->scale.standard_error)},
           {"u_scale", number(r->scale.u_scale)}};
  out["scale_pull"] = r->scale.pull ? number(*r->scale.pull) : json(nullptr);
  return out;
}

template <class... Numbers>
std::string line(const char* format, Numbers... numbers) {
  char buffer[400];
  std::snprintf(buffer, sizeof buffer, format, numbers...);
  return buffer;
}

std::string comb_line(const char* name, const std::optional<FringeComb>& c) {
  if (!c) return "";
  return line(
      "%s fringes: %d and %d from the centre to the edges, spacing %.5f deg (%.3f px), heights %.4g to %.4g sr^-1\n",
      name, c->orders_before, c->orders_after, c->spacing_deg, c->spacing_px, c->first_height_per_sr,
      c->last_height_per_sr);
}

}  // namespace

std::string comparison_json(const Comparison& c, const Provenance& provenance) {
  json out{
      {"measured", features_json(c.measured)}, {"modelled", features_json(c.modelled)}, {"peak_pairs", json::array()}};
  for (const PeakPair& p : c.peaks) {
    out["peak_pairs"].push_back({{"measured_per_sr", number(p.measured.height_per_sr)},
                                 {"modelled_per_sr", number(p.modelled.height_per_sr)},
                                 {"height_ratio", number(p.height_ratio)},
                                 {"distance_px", number(p.distance_px)},
                                 {"angle_deg", number(p.angle_deg)}});
  }
  out["residual"] = residual_json(c.residual);
  out["direction_difference_px"] = number(c.direction_difference_px);
  out["written_by"] = provenance.written_by;
  out["command"] = provenance.command_line;
  for (const InputRecord& i : provenance.inputs) out["inputs"].push_back({{"file", i.path}, {"sha256", i.sha256}});
  constexpr int kIndent = 2;
  return out.dump(kIndent, ' ', false, json::error_handler_t::replace) + "\n";  // names need not be UTF-8
}

std::string comparison_text(const Comparison& c) {
  std::string out;
  for (const PeakPair& p : c.peaks) {
    out += line(
        "peak: measured %.4g sr^-1 at (%.2f, %.2f) px, modelled %.4g sr^-1, ratio %.3f, apart by %.3f px (%.5f deg)\n",
        p.measured.height_per_sr, p.measured.column_px, p.measured.row_px, p.modelled.height_per_sr, p.height_ratio,
        p.distance_px, p.angle_deg);
  }
  out += comb_line("measured", c.measured.along_ridge) + comb_line("modelled", c.modelled.along_ridge);
  if (c.residual) {
    const Residual& r = *c.residual;
    out += line("reduced chi^2 %.4f over %zu pixels; with the scale free %.4f at a factor %.4f +- %.4f",
                r.as_is.per_degree(), r.pixels, r.scaled.per_degree(), r.scale.factor, r.scale.standard_error);
    out += r.scale.pull ? line(", %.2f standard uncertainties of the scale from 1\n", *r.scale.pull) : "\n";
  }
  return out.empty() ? "no feature in common\n" : out;
}

}  // namespace scatmap
