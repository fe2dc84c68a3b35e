#include "scatmap/brdf/measurement.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "scatmap/base/error.h"
#include "scatmap/base/toml_file.h"
#include "scatmap/base/units.h"

namespace scatmap {
namespace {

constexpr NumberRange kCommandedDeg{-360, 360, false};
constexpr NumberRange kPercent{0, 100, false};
constexpr double kMaxOd = 12;

Filter read_filter(const TomlTable& t, const std::string& name) {
  Filter f;
  f.name = name;
  f.od = t.number("od", {0, kMaxOd, false});
  const std::vector<std::string> ways{"tolerance_percent", "tolerance_od", "u_od", "bounds_od"};
  const auto given = std::count_if(ways.begin(), ways.end(), [&](const std::string& w) { return t.has(w); });
  if (given != 1) {
    throw Error({t.where("od"),
                 "states its uncertainty " + std::to_string(given) + " times",
                 {},
                 "one of tolerance_percent, tolerance_od, u_od, bounds_od"});
  }
  if (const auto percent = t.optional_number(ways[0], kPercent)) f.half_width_od = *percent / 100 * f.od;
  if (const auto od = t.optional_number(ways[1], {0, kMaxOd, false})) f.half_width_od = *od;
  if (t.has(ways[0]) || t.has(ways[1]))
    f.distribution = distribution_from(t.choice("distribution", {"rectangular", "triangular"}));
  if (const auto u = t.optional_number(ways[2], {0, kMaxOd, false})) {
    f.half_width_od = *u;
    f.distribution = Distribution::kNormal;
  }
  if (t.has(ways[3])) {
    const std::vector<double> bounds = t.numbers(ways[3], 2, {-kMaxOd, kMaxOd, false});
    if (!(bounds[0] <= 0 && bounds[1] >= 0))
      throw Error({t.where(ways[3]), "does not hold the stated od", {}, "[a number <= 0, a number >= 0]"});
    f.distribution = Distribution::kAsymmetric;
    f.half_width_below_od = -bounds[0];
    f.half_width_od = bounds[1];
  }
  return f;
}

std::vector<std::filesystem::path> resolved(const TomlTable& t, const std::vector<std::string>& names) {
  std::vector<std::filesystem::path> out;
  for (const std::string& n : names) out.push_back(t.resolve(n));
  return out;
}

void read_darks(const TomlTable& t, Exposure& e) {
  e.darks = resolved(t, t.strings_or_empty("darks"));
  if (const auto level = t.optional_number("dark_level_dn", kNotNegative)) {
    e.stated_dark = StatedDark{*level, t.number("u_dark_level_dn", kNotNegative)};
  }
  if (e.darks.empty() && !e.stated_dark)
    throw Error({t.where("darks"), "no dark frame is given", {}, "darks, or dark_level_dn with u_dark_level_dn"});
  if (!e.darks.empty() && e.stated_dark)
    throw Error({t.where("dark_level_dn"), "is given beside darks", {}, "one of them"});
}

Exposure read_exposure(const TomlTable& t, const Measurement& m, double pose_arm_deg, bool is_signature) {
  Exposure e;
  e.where = t.where("frames");
  e.frames = resolved(t, t.strings("frames"));
  if (e.frames.empty()) throw Error({e.where, "lists no frame", {}, {}});
  read_darks(t, e);
  e.exposure_s = t.number("exposure_s", {0, 1e7, true});
  e.u_exposure = t.number_or("u_exposure_percent", 0, kPercent) / 100;
  e.filters = t.strings_or_empty("filters");
  std::set<std::string> seen;
  for (const std::string& name : e.filters) {
    if (!m.filters.contains(name))
      throw Error({t.where("filters"), "names a filter that has no [filters." + name + "]", name, {}});
    if (!seen.insert(name).second) throw Error({t.where("filters"), "names a filter twice", name, {}});
  }
  const auto arm = t.optional_number("arm_deg", kCommandedDeg);
  if (!is_signature && arm && *arm != pose_arm_deg) {
    throw Error({t.where("arm_deg"), "differs from the measurement's arm_deg", std::to_string(*arm),
                 std::to_string(pose_arm_deg) + ": one measurement file is one pose"});
  }
  return e;
}

}  // namespace

Measurement read_measurement(const std::filesystem::path& path) {
  const TomlTable file = TomlTable::read(path);
  Measurement m;
  m.file = path;
  m.instrument_file = file.resolve(file.string("instrument"));
  m.wavelength_m = file.number("wavelength_nm", {1, 1e6, false}) * kMetrePerNm;
  const double arm_deg = file.number("arm_deg", kCommandedDeg);
  m.pose = {file.number("stage_deg", kCommandedDeg) * kRadPerDeg, arm_deg * kRadPerDeg};
  if (const auto filters = file.optional_table("filters")) {
    for (const std::string& name : filters->table_names()) m.filters[name] = read_filter(filters->table(name), name);
  }
  const TomlTable signature = file.table("signature");
  m.signature = read_exposure(signature, m, arm_deg, true);
  m.aperture.radius_px = signature.optional_number("aperture_radius_px", {1, 1e5, false});
  for (const TomlTable& t : file.tables("exposure")) m.exposures.push_back(read_exposure(t, m, arm_deg, false));
  if (m.exposures.empty()) throw Error({file.where("exposure"), "is missing", {}, "at least one table [[exposure]]"});
  if (const auto laser = file.optional_table("laser")) {
    m.laser_drift = laser->number_or("drift_percent", 0, kPercent) / 100;
    m.laser_drift_between_exposures = laser->number_or("drift_between_exposures_percent", 0, kPercent) / 100;
  }
  if (const auto flat = file.optional_string("flat")) m.flat = file.resolve(*flat);
  if (const auto bad = file.optional_string("bad_pixels")) m.bad_pixels = file.resolve(*bad);
  file.reject_unknown_keys();
  m.instrument = read_instrument(m.instrument_file);
  return m;
}

double stack_od(const Measurement& m, const Exposure& e) {
  double sum = 0;
  for (const std::string& name : e.filters) sum += m.filters.at(name).od;
  return sum;
}

ScaleBudget exposure_scale(const Measurement& m, const Exposure& e, double u_signature) {
  ScaleBudget budget;
  const auto holds = [](const Exposure& exposure, const std::string& name) {
    return std::find(exposure.filters.begin(), exposure.filters.end(), name) != exposure.filters.end();
  };
  for (const auto& [name, filter] : m.filters) {
    const int net = static_cast<int>(holds(e, name)) - static_cast<int>(holds(m.signature, name));
    if (net == 0) continue;
    budget.causes.push_back(
        {"filter " + name, filter.distribution, filter.half_width_od, kLn10 * net, true, filter.half_width_below_od});
  }
  const auto add = [&](const char* name, Distribution d, double half_width, double sensitivity) {
    if (half_width > 0) budget.causes.push_back({name, d, half_width, sensitivity, false, 0});
  };
  add("laser drift", Distribution::kRectangular, m.laser_drift, 1);
  add("laser power during frames of the sample", Distribution::kRectangular, m.laser_drift_between_exposures, 1);
  add("exposure time of the sample", Distribution::kNormal, e.u_exposure, -1);
  add("exposure time of the signature", Distribution::kNormal, m.signature.u_exposure, 1);
  add("signature", Distribution::kNormal, u_signature, -1);
  return budget;
}

}  // namespace scatmap
