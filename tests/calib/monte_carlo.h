#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>

#include "bench.h"

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
  double corner_error2_px = 0;  ///< largest direction error of a trial, squared
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

/// rms 1 and coverage 95 % within three standard errors of the trial count, and none beyond four. Of some fifty numbers
/// a run makes, honest ones beyond three happen: one is let pass. Directions at three poses of one trial are one trial,
/// not three.
inline void expect_honest(const Statistics& s) {
  const double n = s.trials, rms_error = 1 / std::sqrt(2 * n), share_error = std::sqrt(0.95 * 0.05 / n);
  int beyond_three = 0;
  const auto check = [&](double value, double expected, double error, const std::string& what) {
    EXPECT_NEAR(value, expected, 4 * error) << what;
    if (!(std::abs(value - expected) <= 3 * error)) ++beyond_three;
  };
  for (const auto& [name, t] : s.one) {
    check(t.rms(), 1, rms_error, "rms z of " + name);
    check(t.coverage(), 0.95, share_error, "coverage of " + name);
  }
  for (const auto& [where, inside] : s.region_inside) {
    check(static_cast<double>(inside) / s.region_count.at(where), 0.95, share_error, "region of directions, " + where);
  }
  EXPECT_LE(beyond_three, 1);
  EXPECT_EQ(s.unconverged, 0);
}

inline void print(const Statistics& s, const std::string& title) {
  std::printf("%s: largest direction error %.3f px rms\n", title.c_str(), std::sqrt(s.corner_error2_px / s.trials));
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
  const ParameterTable table(nominal, {"", {""}, {}}, {});
  Statistics s;
  for (int i = 0; i < trials; ++i) {
    const Lab lab = drawn_lab(rng, noise, targets, table);
    add_trial(lab, calibrate(observe(lab, rng), nominal, options), s);
  }
  return s;
}

}  // namespace scatmap::calib::test
