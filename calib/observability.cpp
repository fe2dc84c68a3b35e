#include "calib/observability.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "scatmap/base/units.h"

namespace scatmap::calib {
namespace {

struct Experiment {
  std::string words;
  std::vector<Target> targets;
};

Target specular(const Target& like, double stage_deg, double arm_offset_deg, double tilt_deg) {
  Target t = like;
  t.stage_rad = stage_deg * kRadPerDeg;
  t.arm_rad = (2 * stage_deg + arm_offset_deg) * kRadPerDeg;
  t.tilt_rad = tilt_deg * kRadPerDeg;
  return t;
}

Target direct(const Target& like, double arm_deg) {
  Target t = like;
  t.kind = TargetKind::kDirect;
  t.arm_rad = arm_deg * kRadPerDeg;
  t.tilt_rad = 0;
  return t;
}

// What can be added to a run, cheapest first.
std::vector<Experiment> experiments(const TargetModel& model, const Used& used) {
  Target like;
  like.sigma_px = model.list().targets[used.front()].sigma_px;
  double stage_deg = 20;
  std::size_t speculars = 0;
  for (const std::size_t i : used) {
    const Target& t = model.list().targets[i];
    if (t.kind != TargetKind::kSpecular) continue;
    like.mount = t.mount;
    stage_deg = t.stage_rad * kDegPerRad;
    ++speculars;
  }
  std::vector<Experiment> out{
      {"add one direct-beam frame (arm at 180 degrees)", {direct(like, 180)}},
      {"add direct-beam frames with the arm 1 degree to either side of 180", {direct(like, 179), direct(like, 181)}}};
  if (model.table().mounts() == 0) return out;
  if (speculars == 0) out.push_back({"add one mirror target", {specular(like, stage_deg, 0, 0)}});
  out.push_back({"add mirror targets with the arm 1 degree to either side of specular",
                 {specular(like, stage_deg, -1, 0), specular(like, stage_deg, 1, 0)}});
  out.push_back({"add targets with the mirror tilted out of plane by known angles of +0.5 and -0.5 degrees",
                 {specular(like, stage_deg, 0, 0.5), specular(like, stage_deg, 0, -0.5)}});
  Experiment range{"add mirror targets at stage angles spread from 10 to 70 degrees", {}}, full{"", {}};
  for (const double s : {10.0, 25.0, 40.0, 55.0, 70.0}) range.targets.push_back(specular(like, s, 0, 0));
  out.push_back(range);
  full.words =
      "add mirror targets at stage angles from 10 to 70 degrees, each with the arm 1 degree to either side and the "
      "mirror tilted by known "
      "angles of +0.5 and -0.5 degrees, and direct-beam frames";
  for (const double s : {10.0, 25.0, 40.0, 55.0, 70.0}) {
    for (const double arm : {-1.0, 1.0}) {
      for (const double tilt : {-0.5, 0.5}) full.targets.push_back(specular(like, s, arm, tilt));
    }
  }
  full.targets.push_back(direct(like, 179));
  full.targets.push_back(direct(like, 181));
  out.push_back(full);
  return out;
}

struct Added {
  std::string words;
  Eigen::MatrixXd information;
};

std::vector<Added> added_information(const TargetModel& model, const Used& used, const FitSet& set,
                                     const Eigen::VectorXd& values) {
  std::vector<Added> out;
  for (const Experiment& e : experiments(model, used)) {
    const TargetList list{"", model.list().mounts, e.targets};
    const TargetModel trial(model.table(), list);
    const Used all = all_targets(list);
    const auto whitening = trial.whitening(values, all);
    if (!whitening) continue;
    const Eigen::MatrixXd j = linearise(trial, all, *whitening, set, values).jacobian;
    out.push_back({e.words, j.transpose() * j});
  }
  return out;
}

// What a bench can measure without its camera: one parameter to a standard deviation, in file units.
struct Direct {
  const char* parameter;
  double sigma;
  const char* words;
};
constexpr Direct kDirect[] = {
    {"stage.zero_deg", 0.002,
     "find the stage angle at which the mirror sends the beam back into itself, write its negative as stage.zero_deg "
     "and say how well it is known with --prior stage.zero_deg=0.002"},
    {"beam.offset_mm.0", 0.01,
     "measure how far the beam passes from the stage axis in x and say how well it is known with --prior "
     "beam.offset_mm.0=0.01"},
    {"beam.offset_mm.1", 0.01,
     "measure how high the beam passes and say how well it is known with --prior beam.offset_mm.1=0.01"},
};

std::vector<Added> measured_directly(const ParameterTable& table, const FitSet& set) {
  std::vector<Added> out;
  const auto n = static_cast<Eigen::Index>(set.size());
  for (const Direct& d : kDirect) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const Fitted& f = set[static_cast<std::size_t>(i)];
      if (table[f.index].name != d.parameter) continue;
      const double ratio = f.scale / (d.sigma * table[f.index].unit);
      Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
      information(i, i) = ratio * ratio;
      out.push_back({d.words, std::move(information)});
    }
  }
  return out;
}

// The first experiment that halves the direction's variance.
std::string remedy_for(const Eigen::VectorXd& direction, const Eigen::MatrixXd& information,
                       const std::vector<Added>& added) {
  const auto variance = [&](const Eigen::MatrixXd& n) { return direction.dot(n.ldlt().solve(direction)); };
  constexpr double kHelps = 0.5;
  const double before = variance(information);
  for (const Added& a : added) {
    if (variance(information + a.information) < kHelps * before) return a.words;
  }
  return "";
}

}  // namespace

Observability observability(const TargetModel& model, const Used& used, const Linearisation& at,
                            const Eigen::VectorXd& values, const DirectionEffects& effects) {
  const Spectrum sp = spectrum(at.jacobian);
  Observability out{sp.values, {}};
  if (sp.values.size() == 0 || sp.values[sp.values.size() - 1] >= 1) return out;
  Eigen::MatrixXd information = at.jacobian.transpose() * at.jacobian;
  information.diagonal().array() += 1;
  std::vector<Added> added = added_information(model, used, at.set, values);
  for (Added& a : measured_directly(model.table(), at.set)) added.push_back(std::move(a));
  const Eigen::MatrixXd f = effects_of(effects, model.table(), at.set);
  for (Eigen::Index i = 0; i < sp.values.size(); ++i) {
    if (sp.values[i] >= 1) continue;
    const Eigen::VectorXd v = sp.vectors.col(i);
    const double effect = (f * v).cwiseAbs().maxCoeff();
    // Below this the value is rounding.
    const double value = sp.values[i] < 1e-12 * sp.values[0] ? 0 : sp.values[i];
    out.blind.push_back({direction_names(v, at.set, model.table()), value, effect, remedy_for(v, information, added)});
  }
  return out;
}

std::string sentence(const BlindDirection& d) {
  char numbers[200];
  const bool single = d.parameters.find(',') == std::string::npos;
  std::snprintf(numbers, sizeof numbers, "; within the tolerances that moves directions by %.2g px", d.effect_px);
  std::string text =
      single ? "the targets do not see " + d.parameters : "the targets cannot tell apart " + d.parameters;
  text += numbers;
  if (!d.remedy.empty()) return text + "; to see it, " + d.remedy;
  return text +
         (d.effect_px < 0.01 ? "; no target can, and nothing depends on it" : "; nothing that was tried tells more");
}

}  // namespace scatmap::calib
