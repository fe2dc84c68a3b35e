#include "scatmap/brdf/measurement.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
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
    f.distribution = *distribution_from(t.choice("distribution", {"rectangular", "triangular"}));
  if (const auto u = t.optional_number(ways[2], {0, kMaxOd, false})) {
    f.half_width_od = *u;
    f.distribution = Distribution::kNormal;
  }
  if (t.has(ways[3])) {
    const std::vector<double> bounds = t.numbers(ways[3], 2, {-kMaxOd, kMaxOd, false});
    if (!(bounds[0] <= 0 && bounds[1] >= 0))
      throw Error({t.where(ways[3]), "does not hold od itself",
                   "[" + number_text(bounds[0]) + ", " + number_text(bounds[1]) + "]",
                   "deviations from od: [a number <= 0, a number >= 0]"});
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
  if (arm) e.arm_rad = *arm * kRadPerDeg;
  if (!is_signature && arm && *arm != pose_arm_deg) {
    throw Error({t.where("arm_deg"), "differs from the measurement's arm_deg", std::to_string(*arm),
                 std::to_string(pose_arm_deg) + ": one measurement file is one pose"});
  }
  return e;
}

// The same numbers twice are no second measurement: sigma would come out too small.
void require_distinct_frames(const std::vector<Exposure>& exposures) {
  const auto key = [](const std::filesystem::path& f) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(f));
  };
  std::set<std::filesystem::path> frames;
  for (const Exposure& e : exposures) {
    for (const std::filesystem::path& f : e.frames) {
      if (!frames.insert(key(f)).second) throw Error({e.where, "names a frame twice", f.string(), {}});
    }
  }
  for (const Exposure& e : exposures) {
    std::set<std::filesystem::path> darks;  // two exposures may share theirs
    for (const std::filesystem::path& f : e.darks) {
      if (!darks.insert(key(f)).second) throw Error({e.where, "has one dark twice", f.string(), {}});
      if (frames.contains(key(f))) throw Error({e.where, "has a dark that is a frame too", f.string(), {}});
    }
  }
}

// One exposure in the table itself, or [[signature.exposure]].
void read_signature(const TomlTable& t, double pose_arm_deg, Measurement& m) {
  m.aperture.radius_px = t.optional_number("aperture_radius_px", {1, 1e5, false});
  const std::vector<TomlTable> tables = t.tables("exposure");
  m.signatures.clear();
  if (tables.empty()) {
    m.signatures.push_back(read_exposure(t, m, pose_arm_deg, true));
    return;
  }
  for (const char* key : {"frames", "darks", "dark_level_dn", "exposure_s", "filters", "u_exposure_percent"}) {
    if (t.has(key)) throw Error({t.where(key), "is given beside [[signature.exposure]]", {}, "one of the two forms"});
  }
  t.optional_number("arm_deg", kCommandedDeg);
  for (const TomlTable& exposure : tables) m.signatures.push_back(read_exposure(exposure, m, pose_arm_deg, true));
}

bool holds(const Exposure& e, const std::string& filter) {
  return std::find(e.filters.begin(), e.filters.end(), filter) != e.filters.end();
}

void add_if_any(ScaleBudget& budget, const std::string& name, Distribution d, double half_width, double sensitivity) {
  if (half_width > 0 && sensitivity != 0) budget.causes.push_back({name, d, half_width, sensitivity, false, 0});
}

void add_filter(ScaleBudget& budget, const Filter& f, double net) {
  if (net == 0) return;
  budget.causes.push_back(
      {"filter " + f.name, f.distribution, f.half_width_od, kLn10 * net, true, f.half_width_below_od});
}

std::string signature_name(const Measurement& m, std::size_t exposure) {
  return m.signatures.size() < 2 ? "the signature" : "signature exposure " + std::to_string(exposure + 1);
}

// Causes of a signature exposure's time and power, `share` times those of its own scale.
void add_times_and_power(const Measurement& m, std::size_t exposure, double share, ScaleBudget& budget) {
  const std::string of = signature_name(m, exposure);
  if (m.signatures.size() > 1) {
    add_if_any(budget, "laser power during frames of " + of, Distribution::kRectangular,
               m.laser_drift_between_exposures, -share);
  }
  add_if_any(budget, "exposure time of " + of, Distribution::kNormal, m.signatures[exposure].u_exposure, -share);
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
  read_signature(file.table("signature"), arm_deg, m);
  for (const TomlTable& t : file.tables("exposure")) m.exposures.push_back(read_exposure(t, m, arm_deg, false));
  if (m.exposures.empty()) throw Error({file.where("exposure"), "is missing", {}, "at least one table [[exposure]]"});
  require_distinct_frames(m.signatures);
  require_distinct_frames(m.exposures);
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

ScaleBudget exposure_scale(const Measurement& m, const Exposure& e, const SignatureUse& signature) {
  ScaleBudget budget;
  std::vector<double> share = signature.share;
  share.resize(m.signatures.size(), 0);
  if (signature.share.empty()) share.front() = 1;
  for (const auto& [name, filter] : m.filters) {
    double net = 0;  // exactly 0 where it cancels
    for (std::size_t j = 0; j < share.size(); ++j)
      net += share[j] * (static_cast<int>(holds(e, name)) - static_cast<int>(holds(m.signatures[j], name)));
    // Shares add to 1 but for rounding.
    constexpr double kRounding = 1e-9;
    add_filter(budget, filter, std::abs(net - std::round(net)) < kRounding ? std::round(net) : net);
  }
  add_if_any(budget, "laser drift", Distribution::kRectangular, m.laser_drift, 1);
  add_if_any(budget, "laser power during frames of the sample", Distribution::kRectangular,
             m.laser_drift_between_exposures, -1);
  add_if_any(budget, "exposure time of the sample", Distribution::kNormal, e.u_exposure, -1);
  for (std::size_t j = 0; j < share.size(); ++j) add_times_and_power(m, j, -share[j], budget);
  add_if_any(budget, "signature", Distribution::kNormal, signature.u, -1);
  return budget;
}

ScaleBudget signature_scale(const Measurement& m, std::size_t exposure) {
  ScaleBudget budget;
  for (const auto& [name, filter] : m.filters) {
    if (holds(m.signatures[exposure], name)) add_filter(budget, filter, 1);
  }
  add_times_and_power(m, exposure, 1, budget);
  return budget;
}

}  // namespace scatmap
