#pragma once
#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calib/targets.h"
#include "scatmap/angles/instrument.h"

namespace scatmap::calib {

enum class Role {
  kCore,      ///< always fitted
  kOptional,  ///< fitted if the targets need it
  kHeld,      ///< stays at its nominal value
  kFree,      ///< always fitted, without a prior (--free)
  kPrior,     ///< always fitted, with the stated prior (--prior)
};

/// What the user says about single parameters, by name.
struct ParameterChoices {
  std::vector<std::string> free;
  std::vector<std::string> fix;
  std::map<std::string, double> prior_sigma;  ///< file units
};

/// A parameter that two of the choices name, and the option that does so second.
struct DoubledChoice {
  std::string option, name;
};
std::optional<DoubledChoice> doubled_choice(const ParameterChoices& choices);

struct Parameter {
  std::string name;        ///< dotted key, or "mount.NAME.tilt_deg", "mount.NAME.height_mm"
  double unit = 1;         ///< metres or radians of one file unit
  double nominal = 0;      ///< m or rad
  double prior_sigma = 0;  ///< mechanical tolerance, m or rad; also the natural scale of the parameter
  Role role = Role::kOptional;
  int rank = 0;  ///< of two that explain the targets alike, the higher one is left out
};

/// Every parameter that targets may say something about: the bench (geometry_keys() without the sample's two), then
/// tilt and height of each mirror mount. A mount without a name is the sample's own: "sample.tilt_deg",
/// "sample.height_mm".
class ParameterTable {
 public:
  /// @throws Error for a choice that names no parameter, is made twice, or a prior that is not positive
  ParameterTable(const Instrument& nominal, const TargetList& list, const ParameterChoices& choices);

  Eigen::Index size() const { return static_cast<Eigen::Index>(all_.size()); }
  const Parameter& operator[](Eigen::Index i) const { return all_[static_cast<std::size_t>(i)]; }
  const Instrument& array() const { return array_; }
  std::size_t mounts() const { return mounts_; }

  Eigen::VectorXd nominal() const;
  /// Bench parameters of `values` (m, rad); sample tilt and height are those of `mount`.
  Geometry<double> geometry(const Eigen::VectorXd& values, std::size_t mount = 0) const;
  /// Index in this table of the parameter in column `key` of geometry_keys(), for a target of `mount`.
  static Eigen::Index index_of_key(Eigen::Index key, std::size_t mount);
  std::optional<Eigen::Index> find(const std::string& name) const;

  /// Changes what the start found out about the array.
  void set_flips(bool columns, bool rows);
  void set_nominal(Eigen::Index i, double value) { all_[static_cast<std::size_t>(i)].nominal = value; }

 private:
  void add_mount(const Instrument& nominal, const std::string& name);
  void choose(const ParameterChoices& choices);
  Parameter& named(const std::string& name, const std::string& option);

  Instrument array_;
  std::size_t mounts_ = 0;
  std::vector<Parameter> all_;
};

/// The mechanical tolerances that stand for whatever targets do not see: "detector.distance_mm=10, …" (file units, one
/// standard deviation), and what is held. For help texts.
std::string default_priors();

inline constexpr Eigen::Index kBenchParameters = static_cast<Eigen::Index>(kGeometryKeyCount) - 2;

}  // namespace scatmap::calib
