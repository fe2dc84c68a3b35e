#include "tools/chart/calibrate.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>

#include "calib/bootstrap.h"
#include "calib/linearisation.h"
#include "calib/start.h"
#include "tools/chart/error_sample.h"
#include "tools/chart/target_bench.h"
#include "tools/chart/timing.h"

namespace scatmap::tools {
namespace {

constexpr std::size_t kTargets = 80;
constexpr int kSessions = 120, kBootstrapTrials = 200;

// What a method says: an instrument, and the uncertainty of its directions if it states one.
struct Answer {
  Instrument instrument;
  std::vector<calib::DirectionSigma> directions;
  bool states_sigma = true;
};

calib::CalibrateOptions options() {
  calib::CalibrateOptions o;
  o.choices.prior_sigma["stage.zero_deg"] = kStageZeroSigma_deg;
  return o;
}

// The parts that the methods are made of. Everything is fitted; nothing is left out or rejected.
class Parts {
 public:
  explicit Parts(const TargetSession& s)
      : start_(calib::starts(calib::ParameterTable(s.nominal, s.list, options().choices), s.list).front()),
        model_(start_.table, s.list) {
    for (Eigen::Index i = 0; i < start_.table.size(); ++i) {
      const calib::Parameter& p = start_.table[i];
      if (p.role == calib::Role::kHeld) {
        start_.values[i] = p.nominal;
      } else {
        set_.push_back({i, start_.values[i], p.prior_sigma, p.prior_sigma, p.nominal});
      }
    }
  }

  Answer start() const { return answer(start_.values, nullptr, false); }
  Answer one_step() const {
    const auto whitening = model_.whitening(start_.values, start_.near);
    const calib::Linearisation at = calib::linearise(model_, start_.near, *whitening, set_, start_.values);
    const Eigen::VectorXd step = -at.normal_matrix().llt().solve(at.gradient());
    Eigen::VectorXd values = start_.values;
    for (std::size_t k = 0; k < set_.size(); ++k)
      values[set_[k].index] += set_[k].scale * step[static_cast<Eigen::Index>(k)];
    return answer(values, &*whitening, true);
  }
  Answer solved(calib::Loss loss) const {
    const auto solution = calib::solve(model_, start_.near, set_, start_.values, {loss, 2, true});
    return answer(solution->values, &solution->whitening, true);
  }

 private:
  Answer answer(const Eigen::VectorXd& values, const calib::Whitening* whitening, bool states_sigma) const {
    Answer out{start_.table.array(), {}, states_sigma};
    out.instrument.geometry = start_.table.geometry(values);
    const calib::DirectionEffects effects = calib::direction_effects(model_, start_.near, values);
    Eigen::MatrixXd covariance =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(set_.size()), static_cast<Eigen::Index>(set_.size()));
    if (whitening != nullptr)
      covariance =
          calib::uncertainty(calib::linearise(model_, start_.near, *whitening, set_, values)).value().covariance;
    out.directions = calib::direction_sigmas(effects, start_.table, set_, covariance);
    return out;
  }

  calib::Start start_;
  calib::TargetModel model_;
  calib::FitSet set_;
};

Answer verb(const TargetSession& s) {
  calib::CalibrationResult r = calib::calibrate(s.list, s.nominal, options());
  return {std::move(r.instrument), std::move(r.directions), true};
}

Answer with_bootstrap(const TargetSession& s, calib::BootstrapKind kind) {
  calib::CalibrationResult r = calib::calibrate(s.list, s.nominal, options());
  return {r.instrument, calib::bootstrap(s.list, r, {kind, kBootstrapTrials, 1}).directions, true};
}

struct Method {
  const char* name;
  std::function<Answer(const TargetSession&)> run;
  const char* note;
};

std::vector<Method> methods() {
  return {
      {"closed-form start", [](const TargetSession& s) { return Parts(s).start(); }, "states no uncertainty"},
      {"one Gauss-Newton step", [](const TargetSession& s) { return Parts(s).one_step(); },
       "from the start, with covariance"},
      {"Levenberg-Marquardt", [](const TargetSession& s) { return Parts(s).solved(calib::Loss::kSquares); },
       "start, fit of everything, covariance"},
      {"robust Levenberg-Marquardt", [](const TargetSession& s) { return Parts(s).solved(calib::Loss::kCauchy); },
       "Cauchy loss; covariance as if it were least squares"},
      {"calibrate", verb, "outliers, smallest set, observability, leave-one-out"},
      {"calibrate, parametric bootstrap",
       [](const TargetSession& s) { return with_bootstrap(s, calib::BootstrapKind::kParametric); }, "200 trials"},
      {"calibrate, residual bootstrap",
       [](const TargetSession& s) { return with_bootstrap(s, calib::BootstrapKind::kResiduals); }, "200 trials"},
      {"calibrate, case bootstrap",
       [](const TargetSession& s) { return with_bootstrap(s, calib::BootstrapKind::kCases); }, "200 trials"},
  };
}

// Errors at the corners over all sessions, px, and how they compare with what was stated.
struct Outcome {
  ErrorSample error_px;
  double z2 = 0;
  int count = 0;
  bool states_sigma = true;

  double claimed_over_observed() const { return 1 / std::sqrt(z2 / count); }
};

Outcome outcome_of(const Method& method, const std::vector<TargetSession>& sessions) {
  Outcome out;
  for (const TargetSession& s : sessions) {
    const Answer a = method.run(s);
    out.states_sigma = a.states_sigma;
    for (const calib::DirectionSigma& d : a.directions) {
      if (d.point.where == "centre") continue;
      const Eigen::Vector2d e = direction_error_px(s, a.instrument, d.point);
      out.error_px.add(e.norm(), static_cast<int>(d.point.column_px), static_cast<int>(d.point.row_px));
      out.z2 += std::pow(e[0] / d.column_px, 2) + std::pow(e[1] / d.row_px, 2);
      out.count += 2;
    }
  }
  return out;
}

std::string note_of(const Method& method, const Outcome& o) {
  if (!o.states_sigma) return method.note;
  char ratio[64];
  std::snprintf(ratio, sizeof ratio, "; sigma claimed/observed %.3f", o.claimed_over_observed());
  return method.note + std::string(ratio);
}

Chart empty_chart(const char* job, const char* title, const char* error, const char* unit, const char* reference) {
  return {job, title, "calibration", error, unit, reference, {}, {}, {}};
}

}  // namespace

std::vector<Chart> chart_calibrate(const ChartSettings& settings) {
  std::mt19937_64 rng(31);
  std::vector<TargetSession> sessions;
  for (int i = 0; i < kSessions; ++i) sessions.push_back(draw_session(kTargets, rng));
  Chart error = empty_chart("calibrate", "Calibration: directions at the frame's corners", "direction error", "px",
                            "the simulator's benches, 120 drawn from the tolerances");
  Chart sigma = empty_chart("calibrate-sigma", "Calibration: how honest the uncertainty of directions is",
                            "deviation of sigma, |claimed / observed - 1|", "", "the scatter over 120 drawn benches");
  for (const Method& method : methods()) {
    ChartRow row;
    row.method = method.name;
    row.size = std::to_string(kTargets) + " targets";
    row.time = with_threads(1, [&] {
      return time_per_item(1, settings.seconds_per_method,
                           [&] { keep(method.run(sessions.front()).directions.data()); });
    });
    const Outcome o = outcome_of(method, sessions);
    row.largest_error = o.error_px.largest();
    row.p99_error = o.error_px.percentile(99);
    row.worst_at = o.error_px.worst_at();
    row.note = note_of(method, o);
    error.rows.push_back(row);
    if (!o.states_sigma) continue;
    row.largest_error = row.p99_error = std::abs(o.claimed_over_observed() - 1);
    row.worst_at.clear();
    sigma.rows.push_back(row);
  }
  // As many benches say no more than this of a standard deviation.
  sigma.error_lines.push_back({"one standard error of 120 benches", 1 / std::sqrt(2.0 * kSessions)});
  return {error, sigma};
}

}  // namespace scatmap::tools
