#include "calib/result.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"

namespace scatmap::calib {
namespace {

struct Context {
  const FinishedFit& finished;
  FitSet set;           // what was fitted
  Linearisation at;     // of that
  Uncertainty scaled;   // of that
  Linearisation whole;  // with what was left out
  Eigen::MatrixXd covariance;
};

Context context_of(const FinishedFit& finished) {
  FitSet set;
  for (std::size_t k = 0; k < finished.all.size(); ++k) {
    if (finished.kept[k]) set.push_back(finished.all[k]);
  }
  const Solution& s = finished.fit.solution;
  Linearisation at = linearise(finished.model, finished.fit.used, s.whitening, set, s.values);
  auto u = uncertainty(at);
  if (!u) {
    throw Error({finished.model.list().name, "does not determine what is left free without a prior",
                 singular_names(at, finished.model.table()),
                 "--fix or --prior for one of them, or more kinds of targets"});
  }
  Linearisation whole = linearise(finished.model, finished.fit.used, s.whitening, finished.all, s.values);
  Eigen::MatrixXd covariance = covariance_with_left_out(whole, finished.model.table(), finished.kept, u->covariance);
  return {finished, set, std::move(at), std::move(*u), std::move(whole), std::move(covariance)};
}

void add_parameters(const Context& c, CalibrationResult& out) {
  const ParameterTable& table = c.finished.model.table();
  out.values = c.finished.fit.solution.values;
  for (Eigen::Index i = 0; i < table.size(); ++i) {
    const Parameter& p = table[i];
    out.parameters.push_back({p.name, p.nominal / p.unit, out.values[i] / p.unit, 0, {}, Outcome::kHeld, 0});
  }
  constexpr double kCarried = 0.25;  // share of the information that the prior brings
  for (std::size_t k = 0; k < c.finished.all.size(); ++k) {
    const Fitted& f = c.finished.all[k];
    const auto i = static_cast<Eigen::Index>(k);
    const double unit = table[f.index].unit;
    ParameterResult& r = out.parameters[static_cast<std::size_t>(f.index)];
    r.sigma = std::sqrt(c.covariance(i, i)) * f.scale / unit;
    if (f.prior_sigma) r.prior_sigma = *f.prior_sigma / unit;
    const bool carried = c.covariance(i, i) * c.whole.prior_information[i] > kCarried;
    r.outcome = !c.finished.kept[k] ? Outcome::kLeftOut : carried ? Outcome::kCarried : Outcome::kFitted;
    if (!c.finished.kept[k] && !c.finished.left_out.empty()) r.bound_px = c.finished.left_out[k].bound_px;
  }
}

// Rows of a setting's whitened residuals against a fit without that setting: r / (1 − leverage).
Eigen::VectorXd without_setting(const Eigen::MatrixXd& leverage, const Eigen::VectorXd& r) {
  const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(r.size(), r.size()) - leverage;
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(rest);
  constexpr double kIndispensable = 1e-6;  // a setting that alone decides something cannot be foretold by the others
  if (!(rest.diagonal().minCoeff() > kIndispensable) || !lu.isInvertible()) {
    return Eigen::VectorXd::Constant(r.size(), std::numeric_limits<double>::quiet_NaN());
  }
  return lu.solve(r);
}

void add_targets(const Context& c, CalibrationResult& out) {
  const TargetModel& model = c.finished.model;
  const std::vector<double> distance = distances(model, out.values);
  for (std::size_t i = 0; i < distance.size(); ++i) {
    TargetResult t;
    t.distance = distance[i];
    const Target& target = model.list().targets[i];
    if (const auto trace = model.trace(out.values, i)) {
      t.residual_px = trace->pixel - Eigen::Vector2d(target.column_px, target.row_px);
      t.sigma_px = model.covariance(target, *trace).diagonal().cwiseSqrt();
    } else {
      t.residual_px.setConstant(std::numeric_limits<double>::quiet_NaN());
    }
    out.targets.push_back(t);
  }
  double sum = 0, count = 0;
  for (const WhiteningBlock& block : c.finished.fit.solution.whitening) {
    const auto first = static_cast<Eigen::Index>(2 * block.first), rows = static_cast<Eigen::Index>(2 * block.count);
    const auto j = c.at.jacobian.middleRows(first, rows);
    const Eigen::MatrixXd leverage = j * c.scaled.covariance * j.transpose();
    const Eigen::VectorXd left_out = without_setting(leverage, c.at.residual.segment(first, rows));
    if (left_out.allFinite()) {
      // Its variance is 1 / (1 − leverage); on average over a good fit the ratio is 1.
      sum += left_out.dot((Eigen::MatrixXd::Identity(rows, rows) - leverage) * left_out);
      count += static_cast<double>(rows);
    }
    const Eigen::MatrixXd factor = block.count == 1 ? Eigen::MatrixXd(block.single) : block.several;
    const Eigen::VectorXd px = factor.triangularView<Eigen::Lower>().solve(left_out);
    for (std::size_t k = 0; k < block.count; ++k) {
      TargetResult& t = out.targets[c.finished.fit.used[block.first + k]];
      t.used = true;
      if (left_out.allFinite()) t.left_out_px = px.segment<2>(2 * static_cast<Eigen::Index>(k));
    }
  }
  out.left_out_rms = count > 0 ? std::sqrt(sum / count) : std::numeric_limits<double>::quiet_NaN();
}

void add_chi2(const Context& c, CalibrationResult& out) {
  const TargetModel& model = c.finished.model;
  out.chi2 = {{"all targets", 0, 0},    {"specular, column", 0, 0},         {"specular, row given column", 0, 0},
              {"direct, column", 0, 0}, {"direct, row given column", 0, 0}, {"priors", 0, 0}};
  const Eigen::VectorXd leverage = (c.at.jacobian * c.scaled.covariance).cwiseProduct(c.at.jacobian).rowwise().sum();
  for (Eigen::Index row = 0; row < c.at.residual.size(); ++row) {
    const Target& t = model.list().targets[c.finished.fit.used[static_cast<std::size_t>(row / 2)]];
    const std::size_t part = (t.kind == TargetKind::kDirect ? 3u : 1u) + static_cast<std::size_t>(row % 2);
    for (const std::size_t k : {std::size_t{0}, part}) {
      out.chi2[k].value += c.at.residual[row] * c.at.residual[row];
      out.chi2[k].degrees += 1 - leverage[row];
    }
  }
  out.chi2[5].value = (c.at.prior_information.array() * c.at.from_prior.array().square()).sum();
  out.chi2[5].degrees =
      (c.at.prior_information.array() * (1 - c.scaled.covariance.diagonal().array() * c.at.prior_information.array()))
          .sum();
}

void add_findings(const Context& c, CalibrationResult& out) {
  const std::size_t rejected = out.targets.size() - c.finished.fit.used.size();
  if (rejected > 0) out.findings.push_back(std::to_string(rejected) + " targets do not fit and were left out");
  const ChiSquare& total = out.chi2.front();
  constexpr double kFar = 4;
  if (total.degrees > 0.5 && std::abs(total.value - total.degrees) > kFar * std::sqrt(2 * total.degrees) + kFar) {
    out.findings.push_back("reduced chi-square is " + number_text(std::round(1e3 * total.value / total.degrees) / 1e3) +
                           ": the stated sigma_px and encoder sigmas are too " +
                           (total.value > total.degrees ? "small" : "large") +
                           " for these targets, and every uncertainty here with them");
  }
  for (std::size_t k = 0; k < c.set.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double pull = c.at.from_prior[i] * std::sqrt(c.at.prior_information[i]);
    if (!(std::abs(pull) > 3)) continue;
    out.findings.push_back("the targets pull " + c.finished.model.table()[c.set[k].index].name + " " +
                           number_text(std::round(10 * std::abs(pull)) / 10) +
                           " prior sigmas away from its nominal value: check it, or give --prior or --free");
  }
  if (c.finished.model.table().mounts() > 1) {
    out.findings.push_back(
        "several mirror mounts: tilt and height of the sample itself stay nominal, without uncertainty; directions are "
        "given for the mount with most targets");
  }
  if (!out.converged) out.findings.push_back("the fit did not converge");
  if (!out.observability.blind.empty()) {
    out.findings.push_back("the targets determine " + std::to_string(out.observability.seen()) + " of " +
                           std::to_string(out.observability.singular_values.size()) +
                           " combinations of parameters; the rest is mechanical tolerance");
  }
}

bool named_key(const std::string& name) {
  return std::any_of(geometry_keys().begin(), geometry_keys().end(),
                     [&](const GeometryKey& k) { return name == k.name; });
}

// The sample stands where the mirror stood if there was one mirror mount only.
std::string instrument_key(const ParameterTable& table, Eigen::Index i) {
  const std::string& name = table[i].name;
  if (named_key(name) || table.mounts() != 1) return name;
  return geometry_keys()[static_cast<std::size_t>(i)].name;
}

void add_instrument(const Context& c, CalibrationResult& out) {
  const ParameterTable& table = c.finished.model.table();
  out.instrument = table.array();
  const Geometry<double> nominal = table.array().geometry;
  out.instrument.geometry = table.geometry(out.values);
  if (table.mounts() != 1) {
    out.instrument.geometry.sample_tilt = nominal.sample_tilt;
    out.instrument.geometry.sample_height = nominal.sample_height;
  }
  Calibration calibration;
  std::vector<Eigen::Index> places;
  std::vector<double> units;
  for (std::size_t k = 0; k < out.set.size(); ++k) {
    const std::string key = instrument_key(table, out.set[k].index);
    if (!named_key(key) || (table.mounts() > 1 && key.rfind("sample.", 0) == 0)) continue;
    calibration.parameters.push_back(key);
    places.push_back(static_cast<Eigen::Index>(k));
    units.push_back(table[out.set[k].index].unit);
  }
  const auto n = static_cast<Eigen::Index>(places.size());
  calibration.covariance.resize(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b <= a; ++b) {
      const double v = out.covariance(places[static_cast<std::size_t>(a)], places[static_cast<std::size_t>(b)]) /
                       (units[static_cast<std::size_t>(a)] * units[static_cast<std::size_t>(b)]);
      calibration.covariance(a, b) = calibration.covariance(b, a) = v;
    }
  }
  for (const ParameterResult& p : out.parameters) {
    if (p.outcome == Outcome::kLeftOut)
      calibration.left_out.push_back(
          {p.name, "not needed by the targets; kept at its nominal value, its uncertainty is in the covariance",
           p.bound_px});
    if (p.outcome == Outcome::kHeld) calibration.left_out.push_back({p.name, "held at its nominal value", {}});
  }
  if (n > 0) out.instrument.calibration = std::move(calibration);
}

}  // namespace

CalibrationResult make_result(const FinishedFit& finished, std::vector<std::string> findings) {
  const Context c = context_of(finished);
  const ParameterTable& table = finished.model.table();
  CalibrationResult out;
  out.findings = std::move(findings);
  out.set = finished.all;
  out.iterations = finished.iterations;
  out.converged = finished.fit.solution.converged;
  out.condition = c.scaled.condition;
  Eigen::VectorXd scale(static_cast<Eigen::Index>(out.set.size()));
  for (std::size_t k = 0; k < out.set.size(); ++k) scale[static_cast<Eigen::Index>(k)] = out.set[k].scale;
  out.covariance = scale.asDiagonal() * c.covariance * scale.asDiagonal();
  add_parameters(c, out);
  const DirectionEffects effects = direction_effects(finished.model, finished.fit.used, out.values);
  out.directions = direction_sigmas(effects, table, out.set, c.covariance);
  out.observability = observability(finished.model, finished.fit.used, c.whole, out.values, effects);
  add_targets(c, out);
  add_chi2(c, out);
  add_findings(c, out);
  add_instrument(c, out);
  return out;
}

}  // namespace scatmap::calib
