#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>

#include "bench.h"
#include "calib/joint_region.h"

/// Repeated noisy calibrations against the simulator's truth: standardised errors of parameters and of directions.
namespace scatmap::calib::test {

struct Noise {
  double sigma_px;
  double encoder_deg;
};

/// Sums of squared standardised errors of one quantity.
struct Tally {
  double sum2 = 0, sum4 = 0;
  int inside = 0, count = 0;

  void add(double z) {
    sum2 += z * z;
    sum4 += z * z * z * z;
    inside += std::abs(z) <= 1.959964 ? 1 : 0;
    ++count;
  }
  double rms() const { return std::sqrt(sum2 / count); }
  double coverage() const { return static_cast<double>(inside) / count; }
};

struct Statistics {
  std::map<std::string, Tally> one;          ///< parameters and direction components
  std::map<std::string, int> region_inside;  ///< 95 % regions of directions, columns and rows together
  std::map<std::string, int> region_count;
  int trials = 0, unconverged = 0;
  int joint_inside = 0, ellipsoid_inside = 0;  ///< all parameters together: likelihood ratio, and covariance alone
  double corner_error2_px = 0;                 ///< largest direction error of a trial, squared
};

/// A bench with every tolerance drawn from its prior: what the lab believes is the mean.
inline Lab drawn_lab(std::mt19937_64& rng, const Noise& noise, std::size_t targets, const ParameterTable& table) {
  std::normal_distribution<double> normal;
  const auto drawn = [&](Eigen::Index i) {
    return (table[i].nominal + table[i].prior_sigma * normal(rng)) / table[i].unit;
  };
  Lab lab{plain_bench(), {{"", 0, 0}}, random_plan(targets, rng), noise.sigma_px};
  synth::Bench& b = lab.bench;
  b.distance_mm = drawn(0);
  b.offset_mm = {drawn(1), drawn(2)};
  b.rotation_deg = {drawn(3), drawn(4), drawn(5)};
  b.arm_zero_deg = drawn(8);
  b.axis_offset_mm = {drawn(9), drawn(10)};
  b.axis_tilt_deg = {drawn(11), drawn(12)};
  b.stage_zero_deg = drawn(13);
  b.beam_offset_mm = {drawn(14), drawn(15)};
  b.beam_elevation_deg = drawn(16);
  lab.mounts[0] = {"", drawn(17), drawn(18)};
  b.arm_encoder_sigma_deg = b.stage_encoder_sigma_deg = noise.encoder_deg;
  return lab;
}

inline Instrument nominal_instrument(const Noise& noise) {
  synth::Bench b = plain_bench();
  b.arm_encoder_sigma_deg = b.stage_encoder_sigma_deg = noise.encoder_deg;
  return believed(b);
}

/// 95 % quantile of chi², Wilson and Hilferty: 0.1 % from four degrees of freedom upwards.
inline double chi2_of_95(double degrees) {
  const double a = 2 / (9 * degrees);
  return degrees * std::pow(1 - a + 1.644854 * std::sqrt(a), 3);
}

// All parameters together, in the two ways there are.
inline void add_joint(const Lab& lab, const TargetList& list, const CalibrationResult& r, Statistics& s) {
  const std::vector<double> truth = true_values(lab);
  const ParameterTable table(r.instrument, list, {});
  const auto n = static_cast<Eigen::Index>(r.set.size());
  Eigen::VectorXd at_truth = r.values, error(n), sigma(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index i = r.set[static_cast<std::size_t>(k)].index;
    at_truth[i] = truth[static_cast<std::size_t>(i)] * table[i].unit;
    sigma[k] = std::sqrt(r.covariance(k, k));
    error[k] = (at_truth[i] - r.values[i]) / sigma[k];
  }
  const Eigen::MatrixXd correlation =
      sigma.cwiseInverse().asDiagonal() * r.covariance * sigma.cwiseInverse().asDiagonal();
  const double limit = chi2_of_95(static_cast<double>(n));
  s.ellipsoid_inside += error.dot(correlation.ldlt().solve(error)) <= limit ? 1 : 0;
  s.joint_inside += joint_chi2(list, r, at_truth) <= limit ? 1 : 0;
}

inline void add_trial(const Lab& lab, const CalibrationResult& r, Statistics& s) {
  const std::vector<double> truth = true_values(lab);
  ++s.trials;
  if (!r.converged) ++s.unconverged;
  for (std::size_t k = 0; k < r.set.size(); ++k) {
    const ParameterResult& p = r.parameters[static_cast<std::size_t>(r.set[k].index)];
    s.one[p.name].add((p.value - truth[static_cast<std::size_t>(r.set[k].index)]) / p.sigma);
  }
  double worst = 0;
  for (const DirectionSigma& d : r.directions) {
    const Eigen::Vector2d e = direction_error_px(lab, r.instrument, d.point);
    s.one["direction across columns, " + d.point.where].add(e[0] / d.column_px);
    s.one["direction across rows, " + d.point.where].add(e[1] / d.row_px);
    constexpr double kChi2Of95 = 5.991465;  // two degrees of freedom
    s.region_inside[d.point.where] += e.dot(d.covariance_px2.ldlt().solve(e)) <= kChi2Of95 ? 1 : 0;
    ++s.region_count[d.point.where];
    worst = std::max(worst, e.norm());
  }
  s.corner_error2_px += worst * worst;
}

/// Two-sided normal quantile at which `count` independent numbers are all inside in 99 of 100 runs (Bonferroni).
inline double bonferroni_sigmas(std::size_t count) {
  double low = 2, high = 8;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (std::erfc(middle / std::sqrt(2)) * static_cast<double>(count) > 0.01 ? low : high) = middle;
  }
  return high;
}

/// rms 1 and coverage 95 %, of single parameters, directions, regions of directions, and all parameters jointly. A run
/// makes some sixty such numbers, of which honest ones lie beyond three standard errors of the trial count in one run
/// of seven: so all must lie within Bonferroni's bound for their number (3.8 standard errors, 1 % for the whole run),
/// at most one beyond three, and no coverage off by more than 5 %. The joint region, being one number, must lie within
/// three. Directions at three poses of one trial are one trial, not three.
inline void expect_honest(const Statistics& s) {
  const double n = s.trials, rms_error = 1 / std::sqrt(2 * n), share_error = std::sqrt(0.95 * 0.05 / n);
  const double most = bonferroni_sigmas(2 * s.one.size() + s.region_inside.size());
  int beyond_three = 0;
  const auto check = [&](double value, double expected, double error, const std::string& what) {
    EXPECT_NEAR(value, expected, most * error) << what;
    if (!(std::abs(value - expected) <= 3 * error)) ++beyond_three;
  };
  const auto check_coverage = [&](double value, const std::string& what) {
    check(value, 0.95, share_error, what);
    EXPECT_NEAR(value, 0.95, 0.05) << what;
  };
  for (const auto& [name, t] : s.one) {
    check(t.rms(), 1, rms_error, "rms z of " + name);
    check_coverage(t.coverage(), "coverage of " + name);
  }
  for (const auto& [where, inside] : s.region_inside)
    check_coverage(static_cast<double>(inside) / s.region_count.at(where), "region of directions, " + where);
  EXPECT_NEAR(s.joint_inside / n, 0.95, std::min(0.05, 3 * share_error)) << "joint region of all parameters";
  EXPECT_LE(beyond_three, 1);
  EXPECT_EQ(s.unconverged, 0);
}

inline void print(const Statistics& s, const std::string& title) {
  std::printf("%s: largest direction error %.3f px rms\n", title.c_str(), std::sqrt(s.corner_error2_px / s.trials));
  std::printf("  all parameters jointly: likelihood ratio %.3f, ellipsoid of the covariance %.3f\n",
              static_cast<double>(s.joint_inside) / s.trials, static_cast<double>(s.ellipsoid_inside) / s.trials);
  for (const auto& [where, inside] : s.region_inside) {
    std::printf("  region, %-44s %.3f\n", where.c_str(), static_cast<double>(inside) / s.region_count.at(where));
  }
  for (const auto& [name, t] : s.one)
    std::printf("  %-52s rms z %.3f, inside 95 %%: %.3f\n", name.c_str(), t.rms(), t.coverage());
}

inline Statistics run_trials(const Noise& noise, std::size_t targets, int trials, std::uint64_t seed,
                             const CalibrateOptions& options) {
  std::mt19937_64 rng(seed);
  const Instrument nominal = nominal_instrument(noise);
  const ParameterTable table(nominal, {"", {""}, {}}, options.choices);
  Statistics s;
  for (int i = 0; i < trials; ++i) {
    const Lab lab = drawn_lab(rng, noise, targets, table);
    const TargetList list = observe(lab, rng);
    const CalibrationResult r = calibrate(list, nominal, options);
    add_trial(lab, r, s);
    add_joint(lab, list, r, s);
  }
  return s;
}

}  // namespace scatmap::calib::test
