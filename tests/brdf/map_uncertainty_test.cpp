// Sums over a map against Monte Carlo: maps drawn from their own random, structured and scale causes. A common 14 %
// does not average down in a mean, a random 4 % does; ratios lose the scale; pose causes keep their signs. Does not
// prove that the map's own images are right: tests/flow does.
#include "scatmap/brdf/map_uncertainty.h"

#include <gtest/gtest.h>

#include <random>

#include "data-synthetic/truth_geometry.h"
#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "scatmap/brdf/pose_uncertainty.h"
#include "tests/counts/made_frames.h"

namespace scatmap {
namespace {

constexpr int kRows = 24, kColumns = 32;
constexpr double kRandom = 0.04, kScale = 0.14;

BrdfMap made_map(bool calibrated) {
  BrdfMap map;
  Instrument& in = map.instrument;
  in.rows = kRows;
  in.columns = kColumns;
  in.geometry.distance = 0.325;
  in.geometry.pixel_column = in.geometry.pixel_row = 200e-6;
  map.pose = {20 * kRadPerDeg, 40 * kRadPerDeg};
  if (calibrated) {
    in.calibration.emplace();
    in.calibration->parameters = {"arm.zero_deg", "detector.distance_mm"};
    in.calibration->covariance = Eigen::MatrixXd::Zero(2, 2);
    in.calibration->covariance(0, 0) = 0.004 * 0.004;
    in.calibration->covariance(1, 1) = 1;
  }
  map.angles = angle_map(in, map.pose);
  map.mask = Grid<Mask>(kRows, kColumns, Mask{0});
  map.brdf_per_sr = Grid<double>(kRows, kColumns);
  map.u_random_per_sr = Grid<float>(kRows, kColumns);
  map.structured = {{"U_NONLIN", "non-linearity", Grid<float>(kRows, kColumns)},
                    {"U_FILTER_A", "filter a", Grid<float>(kRows, kColumns)}};
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const double f = 5 + 100 * std::exp(-(std::pow(r - 11.5, 2) + std::pow(c - 15.5, 2)) / 30);
      map.brdf_per_sr(r, c) = f;
      map.u_random_per_sr(r, c) = static_cast<float>(kRandom * f);
      map.structured[0].sensitivity_per_sr(r, c) = static_cast<float>(0.01 * f * f / 100);
      map.structured[1].sensitivity_per_sr(r, c) = static_cast<float>(c < 16 ? 0.03 * f : 0);
    }
  }
  map.scale.causes = {{"filter b", Distribution::kNormal, kScale, 1, true, 0}};
  if (calibrated) map.u_pose_per_sr = *pose_uncertainty(in, map.pose, map.brdf_per_sr);
  return map;
}

double value_of(const PixelSum& s, const Grid<double>& f) {
  double out = 0;
  for (std::size_t k = 0; k < s.pixels.size(); ++k) out += s.weights[k] * f[s.pixels[k]];
  return out;
}

TEST(MapUncertainty, MeansPowersAndRatiosAgainstMonteCarlo) {
  const BrdfMap map = made_map(false);
  const MapUncertainty u(map);
  const PixelSum left = mean_over(map, {10, 8, 18, 15}), right = mean_over(map, {15, 6, 25, 18}),
                 power = power_in(map, {0, 0, 31, 23});
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  std::vector<double> a, b, p, ratio;
  double product = 0;
  constexpr int kTrials = 4000;
  for (int t = 0; t < kTrials; ++t) {
    const double nonlin = normal(rng), filter = normal(rng), scale = 1 + kScale * normal(rng);
    Grid<double> f = map.brdf_per_sr;
    for (std::size_t i = 0; i < f.size(); ++i) {
      f[i] += map.u_random_per_sr[i] * normal(rng) + nonlin * map.structured[0].sensitivity_per_sr[i] +
              filter * map.structured[1].sensitivity_per_sr[i];
      f[i] *= scale;
    }
    a.push_back(value_of(left, f));
    b.push_back(value_of(right, f));
    p.push_back(value_of(power, f));
    ratio.push_back(a.back() / b.back());
    product += (a.back() - u.of(left).value) * (b.back() - u.of(right).value);
  }
  const double band =
      3 / std::sqrt(2.0 * kTrials) + 0.01;  // and 1 % for products of two deviations, which first order leaves out
  EXPECT_NEAR(u.of(left).total() / test::moments(a).sd, 1, band);
  EXPECT_NEAR(u.of(right).total() / test::moments(b).sd, 1, band);
  EXPECT_NEAR(u.of(power).total() / test::moments(p).sd, 1, band);
  EXPECT_NEAR(ratio_of(u, left, right).u / test::moments(ratio).sd, 1, band);
  EXPECT_NEAR(u.covariance(left, right) / (product / kTrials), 1, 3 * 1.5 / std::sqrt(1.0 * kTrials) + 0.01);
}

TEST(MapUncertainty, CommonPartsStayAndRandomPartsAverageDown) {
  BrdfMap map = made_map(false);
  map.structured.clear();
  const SumUncertainty u = MapUncertainty(map).of(mean_over(map, {0, 0, 31, 23}));
  EXPECT_NEAR(u.scale_relative, 0.14, 1e-12);
  EXPECT_LE(u.random / u.value, kRandom / std::sqrt(100.0));
  EXPECT_NEAR(u.total() / u.value, std::hypot(0.14, u.random / u.value), 1e-12);
}

TEST(MapUncertainty, PoseOfOnePixelIsTheMaps) {
  const BrdfMap map = made_map(true);
  const MapUncertainty u(map);
  for (const auto& [c, r] : {std::pair{15, 11}, {10, 4}, {22, 15}}) {
    const SumUncertainty one = u.of(mean_over(map, {c, r, c, r}));
    double pose = 0;
    for (const CauseAmount& s : one.structured) pose += s.name.rfind("pose", 0) == 0 ? s.amount * s.amount : 0;
    EXPECT_NEAR(std::sqrt(pose) / map.u_pose_per_sr(r, c), 1, 1e-6);
  }
}

// The bench believed is `nominal`, the true one is drawn (as in pose_uncertainty_test.cpp): what a region's mean does.
TEST(MapUncertainty, PoseOfARegionAgainstMonteCarlo) {
  synth::Bench nominal_bench;
  nominal_bench.columns = kColumns;
  nominal_bench.rows = kRows;
  nominal_bench.pitch_um = {200, 200};
  nominal_bench.distance_mm = 325;
  const synth::TruthGeometry nominal(nominal_bench, 20, 40);
  const auto lobe = [](const synth::TruthGeometry& g, const synth::Vec3& direction) {
    const synth::Vec3 h = g.to_source() + direction;
    const double hx = static_cast<double>(h.x / h.z), hy = static_cast<double>(h.y / h.z);
    return 5 + 100 * std::exp(-(hx * hx + hy * hy) / (1e-3 * 1e-3));
  };
  BrdfMap map = made_map(true);
  map.structured.clear();
  map.scale = {};
  Grid<double> projected(kRows, kColumns);
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const auto p = nominal.pixel(c, r);
      map.brdf_per_sr(r, c) = lobe(nominal, p->direction);
      map.u_random_per_sr(r, c) = 1e-6f;
      projected(r, c) = static_cast<double>(p->solid_angle_sr * std::cos(p->theta_s_rad));
    }
  }
  map.u_pose_per_sr = *pose_uncertainty(map.instrument, map.pose, map.brdf_per_sr);
  const PixelSum flank = mean_over(map, {11, 8, 14, 15}), both = mean_over(map, {10, 8, 21, 15});
  std::mt19937_64 rng(2);
  std::normal_distribution<double> normal;
  std::vector<double> of_flank, of_both;
  constexpr int kTrials = 600;
  for (int t = 0; t < kTrials; ++t) {
    synth::Bench b = nominal_bench;
    b.arm_zero_deg += 0.004 * normal(rng);
    b.distance_mm += normal(rng);
    const synth::TruthGeometry truth(b, 20, 40);
    Grid<double> f(kRows, kColumns, 0.0);
    for (const std::size_t i : both.pixels) {
      const int r = static_cast<int>(i) / kColumns, c = static_cast<int>(i) % kColumns;
      const auto p = truth.pixel(c, r);
      f[i] =
          lobe(truth, p->direction) * static_cast<double>(p->solid_angle_sr * std::cos(p->theta_s_rad)) / projected[i];
    }
    of_flank.push_back(value_of(flank, f));
    of_both.push_back(value_of(both, f));
  }
  const MapUncertainty u(map);
  const double band = 3 / std::sqrt(2.0 * kTrials) + 0.04;  // and the lobe's curvature: shifts of 0.1 px here
  EXPECT_NEAR(u.of(flank).total() / test::moments(of_flank).sd, 1, band);
  EXPECT_NEAR(u.of(both).total() / test::moments(of_both).sd, 1, band);
  EXPECT_GT(u.of(flank).total() / u.of(flank).value, 2 * u.of(both).total() / u.of(both).value);  // flanks cancel
}

TEST(MapUncertainty, FiltersOfSingleExposuresMultiply) {
  BrdfMap map = made_map(false);
  map.structured[1].cause = {"filter a", Distribution::kRectangular, 0.0226, 1, true,
                             0};  // 0.0226 OD/sqrt(3)·ln 10 = 3 %
  const MapUncertainty u(map);
  const SumUncertainty left = u.of(mean_over(map, {3, 3, 3, 3})), right = u.of(mean_over(map, {20, 3, 20, 3}));
  const ScaleBudget of_left = factor_budget(left, map.scale), of_right = factor_budget(right, map.scale);
  EXPECT_NEAR(std::hypot(of_left.standard(), left.relative_additive()), left.total() / left.value, 1e-6);
  ASSERT_EQ(of_left.causes.size(), 3u);
  EXPECT_EQ(of_right.causes.size(), 2u);  // that filter was not in the way there
  EXPECT_EQ(of_left.causes[2].distribution, Distribution::kRectangular);
  EXPECT_NEAR(of_left.causes[2].sensitivity, kLn10, 0.01);
}

TEST(MapUncertainty, FilterTargetsGiveBackTheTarget) {
  ScaleBudget b;
  for (const double od : {4.0, 3.0, 1.0})
    b.causes.push_back({"filter " + std::to_string(od), Distribution::kRectangular, 0.05 * od, kLn10, true, 0});
  const double other = 0.04, target = 0.15;
  int reachable = 0;
  for (const FilterTarget& t : filter_targets(b, other, target)) {
    if (!t.u_od) continue;
    ++reachable;
    ScaleBudget calibrated = b;
    for (ScaleCause& c : calibrated.causes) {
      if (std::find(t.filters.begin(), t.filters.end(), c.name) != t.filters.end()) {
        c.distribution = Distribution::kNormal;
        c.half_width = *t.u_od;
      }
    }
    EXPECT_NEAR(std::hypot(calibrated.standard(), other), target, 1e-12);
  }
  EXPECT_EQ(reachable, 2);  // nd30's 19.9 % alone is too much
  EXPECT_FALSE(filter_targets(b, other, target).front().u_od.has_value());
}

TEST(MapUncertainty, RefusesRegionsOutsideAndModelledMaps) {
  BrdfMap map = made_map(false);
  EXPECT_THROW(mean_over(map, {0, 0, 32, 5}), Error);
  EXPECT_THROW(mean_over(map, {5, 0, 4, 5}), Error);
  for (Mask& m : map.mask) m = kBad;
  EXPECT_THROW(mean_over(map, {0, 0, 3, 3}), Error);
  map.u_random_per_sr = {};
  EXPECT_THROW(MapUncertainty{map}, Error);
}

}  // namespace
}  // namespace scatmap
