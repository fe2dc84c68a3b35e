#include "calib/calibrate.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "calib/consensus.h"
#include "calib/linearisation.h"
#include "calib/result.h"
#include "calib/selection.h"
#include "calib/start.h"
#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"

namespace scatmap::calib {
namespace {

FitSet candidates(const ParameterTable& table, const Eigen::VectorXd& start) {
  FitSet set;
  for (Eigen::Index i = 0; i < table.size(); ++i) {
    const Parameter& p = table[i];
    if (p.role == Role::kHeld) continue;
    Fitted f{i, start[i], p.prior_sigma, p.prior_sigma, p.nominal};
    if (p.role == Role::kFree) f.prior_sigma.reset();
    set.push_back(f);
  }
  return set;
}

Eigen::VectorXd away_from_nominal(const ParameterTable& table, const FitSet& set, const Eigen::VectorXd& values) {
  Eigen::VectorXd away(static_cast<Eigen::Index>(set.size()));
  for (std::size_t k = 0; k < set.size(); ++k) {
    away[static_cast<Eigen::Index>(k)] = (values[set[k].index] - table[set[k].index].nominal) / set[k].scale;
  }
  return away;
}

FitSet only(const FitSet& set, const std::vector<bool>& kept) {
  FitSet out;
  for (std::size_t k = 0; k < set.size(); ++k) {
    if (kept[k]) out.push_back(set[k]);
  }
  return out;
}

// Bayesian information criterion, with a floor for very small lists: one parameter must gain this much chi².
double selection_threshold(const Used& used) {
  constexpr double kFloor = 3.84;  // 95 % of chi² with one degree of freedom
  return std::max(kFloor, std::log(2.0 * static_cast<double>(used.size())));
}

class Run {
 public:
  Run(const TargetList& list, const Start& start, const CalibrateOptions& options)
      : options_(options), table_(start.table), model_(table_, list), start_(start.values) {
    for (Eigen::Index i = 0; i < table_.size(); ++i) {
      if (table_[i].role == Role::kHeld) start_[i] = table_[i].nominal;
    }
    all_ = candidates(table_, start_);
    kept_.assign(all_.size(), true);
    fit_ = consensus(model_, start.near, all_, start_, options_.reject_sigma, false);
    iterations_ = fit_.solution.iterations;
  }

  double disagreement() const { return calib::disagreement(distances(model_, fit_.solution.values)); }

  void choose() {
    Linearisation at = linearise(model_, fit_.used, fit_.solution.whitening, all_, fit_.solution.values);
    drop_overruled_priors(at, table_);
    all_ = at.set;
    if (options_.select) {
      const Eigen::MatrixXd effects =
          effects_of(direction_effects(model_, fit_.used, fit_.solution.values), table_, all_);
      kept_ = needed(at, table_, away_from_nominal(table_, all_, fit_.solution.values), effects,
                     {selection_threshold(fit_.used), options_.tolerance_px});
    }
    refit();
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds && take_back(); ++round) refit();
  }

  CalibrationResult result(std::vector<std::string> findings) const {
    return make_result({model_, fit_, all_, kept_, left_out_, iterations_}, std::move(findings));
  }

 private:
  void refit() {
    const FitSet set = only(all_, kept_);
    Eigen::VectorXd from = fit_.solution.values;
    for (std::size_t k = 0; k < all_.size(); ++k) {
      if (!kept_[k]) from[all_[k].index] = table_[all_[k].index].nominal;
    }
    fit_ = consensus(model_, fit_.used, set, from, options_.reject_sigma, true);
    iterations_ += fit_.solution.iterations;
  }

  // What leaving out costs, at the solution without; true if a parameter has to come back.
  bool take_back() {
    const DirectionEffects effects = direction_effects(model_, fit_.used, fit_.solution.values);
    FitSet set = only(all_, kept_);
    left_out_.assign(all_.size(), {});
    bool back = false;
    for (std::size_t k = 0; k < all_.size(); ++k) {
      if (kept_[k]) continue;
      set.push_back(all_[k]);
      const Linearisation with = linearise(model_, fit_.used, fit_.solution.whitening, set, fit_.solution.values);
      left_out_[k] = left_out_cost(with, effects_of(effects, table_, set));
      set.pop_back();
      if (left_out_[k].chi2 > 2 * selection_threshold(fit_.used)) {
        kept_[k] = true;
        back = true;
      }
    }
    return back;
  }

  const CalibrateOptions& options_;
  ParameterTable table_;
  TargetModel model_;
  Eigen::VectorXd start_;
  FitSet all_;
  std::vector<bool> kept_;
  std::vector<LeftOutCost> left_out_;
  Consensus fit_;
  int iterations_ = 0;
};

// Centroids in millimetres, angles in radians: such targets may fit a bench, but none like the nominal one.
void require_same_bench(const TargetList& list, const Instrument& nominal, const Instrument& fitted) {
  constexpr double kMostRatio = 3;
  const double ratio = fitted.geometry.distance / nominal.geometry.distance;
  if (ratio < kMostRatio && ratio > 1 / kMostRatio) return;
  throw Error({list.name, "fits only a bench that does not resemble the nominal one: check the units of its columns",
               "detector.distance_mm = " + number_text(fitted.geometry.distance * 1e3),
               "about " + number_text(nominal.geometry.distance * 1e3)});
}

// Beyond this the residuals are no noise of any stated size, and no uncertainty made from them means anything.
void require_agreement(const TargetList& list, const ChiSquare& total) {
  constexpr double kMostRatio = 10;
  const double ratio = total.degrees > 0 ? std::sqrt(total.value / total.degrees) : 0;
  if (ratio < kMostRatio) return;
  throw Error(
      {list.name, "does not agree with itself or with any bench",
       "residuals " + number_text(std::round(ratio)) + " times as large as sigma_px and the encoder sigmas allow",
       "targets that do not contradict each other, and sigmas that are not ten times too small"});
}

}  // namespace

CalibrationResult calibrate(const TargetList& list, const Instrument& nominal, const CalibrateOptions& options) {
  if (nominal.lens_cameramodel) {
    throw Error({"detector.lens_cameramodel", "cannot be calibrated: only a bare, flat detector can",
                 nominal.lens_cameramodel->string(), "an instrument without a lens; calibrate the lens with mrcal"});
  }
  const ParameterTable table(nominal, list, options.choices);
  std::unique_ptr<Run> best;
  std::vector<std::string> findings;
  std::optional<Error> first_problem;
  for (const Start& start : starts(table, list)) {
    try {
      auto run = std::make_unique<Run>(list, start, options);
      if (best != nullptr && !(run->disagreement() < best->disagreement())) continue;
      best = std::move(run);
      findings = start.findings;
    } catch (const Error& e) {
      if (!first_problem) first_problem = e;
      continue;
    }
    constexpr double kAgreed = 1.2;  // a mean distance of 3 standard deviations
    if (best->disagreement() < kAgreed) break;
  }
  if (best == nullptr) throw *first_problem;
  best->choose();
  CalibrationResult result = best->result(findings);
  require_same_bench(list, nominal, result.instrument);
  require_agreement(list, result.chi2.front());
  return result;
}

}  // namespace scatmap::calib
