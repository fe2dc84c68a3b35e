#include "calib/parameters.h"

#include <set>

#include "calib/trace.h"
#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"

namespace scatmap::calib {
namespace {

struct Default {
  double prior_sigma;  // file units
  Role role;
  int rank;
};

// In the order of geometry_keys(). Tolerances of a bench set up with rule, level and alignment laser. The pixel pitch
// is the maker's and far better than any target: with it free, lengths have no scale.
constexpr Default kDefaults[] = {
    {10, Role::kCore, 0},                                  // distance
    {3, Role::kCore, 1},                                   // offset x
    {3, Role::kCore, 1},                                   // offset y
    {0.5, Role::kOptional, 6},                             // pitch
    {0.5, Role::kOptional, 7},                             // yaw
    {2, Role::kCore, 1},                                   // roll
    {0.05, Role::kHeld, 8},                                // pixel pitch
    {0.05, Role::kHeld, 8},    {0.2, Role::kOptional, 3},  // arm zero
    {0.2, Role::kOptional, 5},                             // arm axis offset
    {0.2, Role::kOptional, 5}, {0.1, Role::kOptional, 6},  // arm axis tilt
    {0.1, Role::kOptional, 6}, {0.5, Role::kCore, 1},      // stage zero
    {0.2, Role::kOptional, 4},                             // beam offset
    {0.2, Role::kOptional, 5}, {0.1, Role::kOptional, 4},  // beam elevation
    {0.5, Role::kCore, 1},                                 // mount tilt
    {0.5, Role::kOptional, 2},                             // mount height
};
static_assert(std::size(kDefaults) == kGeometryKeyCount);

Parameter parameter_of(Eigen::Index key, const Instrument& nominal, const std::string& name) {
  const GeometryKey& k = geometry_keys()[static_cast<std::size_t>(key)];
  const Default& d = kDefaults[key];
  return {name, k.unit, nominal.geometry.*k.member, d.prior_sigma * k.unit, d.role, d.rank};
}

}  // namespace

std::string default_priors() {
  std::string text, held;
  for (std::size_t i = 0; i < kGeometryKeyCount; ++i) {
    std::string& list = kDefaults[i].role == Role::kHeld ? held : text;
    list += (list.empty() ? "" : ", ") + std::string(geometry_keys()[i].name);
    if (kDefaults[i].role != Role::kHeld) list += "=" + number_text(kDefaults[i].prior_sigma);
  }
  return text + "; held: " + held;
}

ParameterTable::ParameterTable(const Instrument& nominal, const TargetList& list, const ParameterChoices& choices)
    : array_(nominal), mounts_(list.mounts.size()) {
  for (Eigen::Index i = 0; i < kBenchParameters; ++i) {
    all_.push_back(parameter_of(i, nominal, geometry_keys()[static_cast<std::size_t>(i)].name));
  }
  for (const std::string& mount : list.mounts) add_mount(nominal, mount);
  choose(choices);
}

void ParameterTable::add_mount(const Instrument& nominal, const std::string& name) {
  const std::string prefix = name.empty() ? "sample" : "mount." + name;
  all_.push_back(parameter_of(kTiltColumn, nominal, prefix + ".tilt_deg"));
  all_.push_back(parameter_of(kHeightColumn, nominal, prefix + ".height_mm"));
}

Parameter& ParameterTable::named(const std::string& name, const std::string& option) {
  if (const auto i = find(name)) return all_[static_cast<std::size_t>(*i)];
  std::string names;
  for (const Parameter& p : all_) names += (names.empty() ? "" : ", ") + p.name;
  throw Error({option, "names no parameter", name, names});
}

std::optional<DoubledChoice> doubled_choice(const ParameterChoices& choices) {
  std::set<std::string> seen;
  for (const std::string& name : choices.free) {
    if (!seen.insert(name).second) return DoubledChoice{"--free", name};
  }
  for (const std::string& name : choices.fix) {
    if (!seen.insert(name).second) return DoubledChoice{"--fix", name};
  }
  for (const auto& [name, sigma] : choices.prior_sigma) {
    if (!seen.insert(name).second) return DoubledChoice{"--prior", name};
  }
  return std::nullopt;
}

void ParameterTable::choose(const ParameterChoices& choices) {
  if (const auto twice = doubled_choice(choices))
    throw Error({twice->option, "says a second thing about a parameter", twice->name, {}});
  for (const std::string& name : choices.free) named(name, "--free").role = Role::kFree;
  for (const std::string& name : choices.fix) named(name, "--fix").role = Role::kHeld;
  for (const auto& [name, sigma] : choices.prior_sigma) {
    Parameter& p = named(name, "--prior");
    if (!(sigma > 0 && sigma < 1e9))
      throw Error({"--prior", "needs a positive standard deviation for " + name, number_text(sigma), {}});
    p.prior_sigma = sigma * p.unit;
    p.role = Role::kPrior;
  }
}

Eigen::VectorXd ParameterTable::nominal() const {
  Eigen::VectorXd values(size());
  for (Eigen::Index i = 0; i < size(); ++i) values[i] = (*this)[i].nominal;
  return values;
}

Geometry<double> ParameterTable::geometry(const Eigen::VectorXd& values, std::size_t mount) const {
  Geometry<double> g;
  for (Eigen::Index key = 0; key < static_cast<Eigen::Index>(kGeometryKeyCount); ++key) {
    const Eigen::Index i = index_of_key(key, mount);
    if (i < size()) g.*geometry_keys()[static_cast<std::size_t>(key)].member = values[i];
  }
  if (mounts_ > 0) return g;
  g.sample_tilt = array_.geometry.sample_tilt;
  g.sample_height = array_.geometry.sample_height;
  return g;
}

Eigen::Index ParameterTable::index_of_key(Eigen::Index key, std::size_t mount) {
  return key < kBenchParameters ? key : key + 2 * static_cast<Eigen::Index>(mount);
}

std::optional<Eigen::Index> ParameterTable::find(const std::string& name) const {
  for (Eigen::Index i = 0; i < size(); ++i) {
    if ((*this)[i].name == name) return i;
  }
  return std::nullopt;
}

void ParameterTable::set_flips(bool columns, bool rows) {
  array_.flip_columns = columns;
  array_.flip_rows = rows;
}

}  // namespace scatmap::calib
