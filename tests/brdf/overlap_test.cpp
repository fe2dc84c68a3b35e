// Transmittance ratios from overlapping exposures: the filters come out, the claimed covariance is the spread over many
// seeds with filters drawn from their tolerances, and a leak, a wrong exposure time and a non-linear sensor are
// reported and not averaged. Counts are made here, photon by photon, without frames: what frames add is tested in
// tests/flow. Does not prove that two real exposures differ by nothing else than their filters.
#include "scatmap/brdf/overlap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "scatmap/base/units.h"

namespace scatmap {
namespace {

constexpr int kSide = 48;
constexpr double kGain = 1.5, kReadNoise_e = 8, kFull_e = 90000;

// A lobe of 2e6 electrons without filter on a floor of 300: three exposures at OD 2, 1 and 0 see all of it together.
double unfiltered_e(int row, int column) {
  const double d2 = std::pow(row - 20.3, 2) + std::pow(column - 25.7, 2);
  return 300 + 2e6 * std::exp(-d2 / 40);
}

struct Optics {
  std::vector<double> true_od, od;  // per filter: nd20, nd10
  double tolerance = 0.05;          // of OD, rectangular
  double leak_e = 0, leaky = 0;     // additive light in one exposure
  double curvature = 0;             // relative, at full scale
  std::vector<double> time_error{0, 0, 0};
};

struct World {
  std::vector<Counts> counts;
  std::vector<ScaledCounts> scaled;
  ExposureCauses causes;
};

Counts counts_of(double transmittance, const Optics& s, std::size_t exposure, std::mt19937_64& rng) {
  Counts c{{kSide, kSide}, {kSide, kSide}, {kSide, kSide}, {kSide, kSide}, {kSide, kSide}, 1, 0, 0};
  std::normal_distribution<double> read(0, kReadNoise_e);
  for (int r = 0; r < kSide; ++r) {
    for (int k = 0; k < kSide; ++k) {
      double mean = unfiltered_e(r, k) * transmittance * (1 + s.time_error[exposure]);
      if (exposure == static_cast<std::size_t>(s.leaky) && s.leak_e > 0)
        mean += s.leak_e * (0.5 + k / static_cast<double>(kSide));
      const double e = static_cast<double>(std::poisson_distribution<long>(mean)(rng));
      const double seen = e * (1 + s.curvature * e / kFull_e) + read(rng);
      c.rate_dn_per_s(r, k) = std::round(seen / kGain);
      c.frame_floor(r, k) = static_cast<float>((kReadNoise_e * kReadNoise_e) / (kGain * kGain) + 1.0 / 12);
      c.shot(r, k) = static_cast<float>(1 / kGain);
      c.dark_floor(r, k) = 0;
      c.mask(r, k) = seen > kFull_e ? kSaturated : Mask{0};
    }
  }
  return c;
}

World world(const Optics& s, std::uint64_t seed) {
  World w;
  std::mt19937_64 rng(seed);
  const std::vector<std::vector<std::size_t>> stacks{{0}, {1}, {}};
  w.causes.sensitivity = Eigen::MatrixXd::Zero(3, 2);
  for (std::size_t f = 0; f < 2; ++f) {
    w.causes.causes.push_back(
        {"filter " + std::to_string(f), Distribution::kRectangular, s.tolerance * s.od[f], 1, true, 0});
    w.causes.sensitivity(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(f)) = kLn10;
  }
  std::vector<double> factors;
  for (std::size_t e = 0; e < stacks.size(); ++e) {
    double od = 0, true_od = 0;
    for (const std::size_t f : stacks[e]) {
      od += s.od[f];
      true_od += s.true_od[f];
    }
    w.counts.push_back(counts_of(std::pow(10, -true_od), s, e, rng));
    factors.push_back(std::pow(10, od));
  }
  for (std::size_t e = 0; e < factors.size(); ++e) w.scaled.push_back({&w.counts[e], factors[e], static_cast<int>(e)});
  return w;
}

OverlapSolution solve(const World& w, double u_nonlinearity = 0) {
  std::vector<double> level;
  for (const ScaledCounts& s : w.scaled) level.push_back(kGain / (s.factor * kFull_e));
  return solve_overlap(std::vector<OverlapGroup>{{w.scaled, level}}, w.causes, u_nonlinearity);
}

TEST(Overlap, FiltersComeOutWithHonestSigmaAndNoSeam) {
  constexpr int kTrials = 300;
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> within(-1, 1);
  double square[2] = {0, 0}, sum[2] = {0, 0}, cross = 0, claimed_cross = 0, worst_seam = 0;
  int covered[2] = {0, 0};
  for (int t = 0; t < kTrials; ++t) {
    Optics s{{2 + 0.1 * within(rng), 1 + 0.05 * within(rng)}, {2, 1}};
    const OverlapSolution o = solve(world(s, 1000 + static_cast<std::uint64_t>(t)));
    double z[2];
    for (int f = 0; f < 2; ++f) {
      const auto i = static_cast<std::size_t>(f);
      z[f] = (s.od[i] + o.shift[f] - s.true_od[i]) / std::sqrt(o.covariance(f, f));
      square[f] += z[f] * z[f];
      sum[f] += z[f];
      covered[f] += std::abs(z[f]) < 1.959964 ? 1 : 0;
      EXPECT_LE(std::sqrt(o.covariance(f, f)), 1e-3);  // 0.0577 and 0.0289 before
    }
    cross += z[0] * z[1];
    claimed_cross += o.covariance(0, 1) / std::sqrt(o.covariance(0, 0) * o.covariance(1, 1));
    for (const OverlapPair& p : o.pairs) {
      EXPECT_TRUE(p.problem.empty()) << p.problem;
      if (p.used) worst_seam = std::max(worst_seam, std::abs(p.ln_ratio) - 3 * p.u);
    }
  }
  for (int f = 0; f < 2; ++f) {
    EXPECT_NEAR(std::sqrt(square[f] / kTrials), 1, 3 / std::sqrt(2.0 * kTrials)) << f;
    EXPECT_NEAR(sum[f] / kTrials, 0, 3 / std::sqrt(1.0 * kTrials)) << f;
    EXPECT_NEAR(covered[f], 0.95 * kTrials, 3 * std::sqrt(0.95 * 0.05 * kTrials)) << f;
  }
  EXPECT_NEAR(cross / kTrials, claimed_cross / kTrials, 3 * 1.5 / std::sqrt(1.0 * kTrials));
  EXPECT_LE(worst_seam, 2e-3);
}

TEST(Overlap, ANonlinearSensorIsConsideredInTheCovariance) {
  constexpr int kTrials = 150;
  constexpr double kU = 0.01;
  std::mt19937_64 rng(4);
  std::normal_distribution<double> normal;
  double square = 0, cross = 0, claimed = 0;
  for (int t = 0; t < kTrials; ++t) {
    const double z = normal(rng);
    Optics s{{2.05, 0.97}, {2, 1}};
    s.curvature = -kU * z;  // true = seen (1 + u level z)
    const OverlapSolution o = solve(world(s, 5000 + static_cast<std::uint64_t>(t)), kU);
    const double u = std::sqrt(o.covariance(0, 0)), error = 2.05 - (2 + o.shift[0]);
    square += error * error / (u * u);
    cross += error / u * z;
    claimed += o.covariance(0, 2) / u;
    for (const OverlapPair& p : o.pairs) EXPECT_TRUE(p.problem.empty()) << p.problem;
  }
  EXPECT_NEAR(std::sqrt(square / kTrials), 1, 3 / std::sqrt(2.0 * kTrials) + 0.03);
  EXPECT_NEAR(cross / kTrials, claimed / kTrials, 3 / std::sqrt(1.0 * kTrials) + 0.05);
  EXPECT_GT(std::abs(claimed) / kTrials, 0.5);  // and it matters here
}

// What photons do on average, and no read noise.
World without_noise(const Optics& s) {
  World w = world(s, 1);
  const double transmittance[] = {std::pow(10, -s.true_od[0]), std::pow(10, -s.true_od[1]), 1};
  for (std::size_t e = 0; e < w.counts.size(); ++e) {
    Counts& c = w.counts[e];
    for (int r = 0; r < kSide; ++r) {
      for (int k = 0; k < kSide; ++k) {
        const double mean = unfiltered_e(r, k) * transmittance[e];
        c.rate_dn_per_s(r, k) = mean * (1 + s.curvature * mean / kFull_e) / kGain;
        c.frame_floor(r, k) = 1e-6f;
        c.mask(r, k) = mean > kFull_e ? kSaturated : Mask{0};
      }
    }
  }
  return w;
}

// With filters off by a tenth of their tolerances and by all of them: a pixel's level follows from its counts.
TEST(Overlap, TheShareOfANonlinearSensorIsTheDifferenceQuotient) {
  constexpr double kU = 0.01, kStep = 0.1;
  for (const double off : {0.1, 1.0}) {
    const auto with = [&](double z) {
      Optics s{{2 + 0.1 * off, 1 - 0.05 * off}, {2, 1}};
      s.curvature = -kU * z;
      return solve(without_noise(s), kU);
    };
    const OverlapSolution up = with(kStep), down = with(-kStep), at = with(0);
    for (int f = 0; f < 2; ++f) {
      const double quotient = (up.shift[f] - down.shift[f]) / (2 * kStep);
      EXPECT_NEAR(-at.covariance(f, 2) / quotient, 1, 5e-3) << "filter " << f << " off by " << off;
      EXPECT_GE(std::abs(quotient), 3e-4);  // there is something to compare
    }
  }
}

// The ratio of two totals of N_a and N_b photons is known to sqrt(1/N_a + 1/N_b). The peak is cut off where an exposure
// saturates, so that its flanks weigh.
TEST(Overlap, SigmaOfARatioIsThatOfThePhotonsInBothOnTheFlanksOfAPeak) {
  const World w = without_noise({{2, 1}, {2, 1}});
  const OverlapSolution o = solve(w);
  ASSERT_EQ(o.pairs.size(), 3u);
  for (const OverlapPair& p : o.pairs) {
    double of_a = 0, of_b = 0;
    for (std::size_t i = 0; i < w.counts[0].mask.size(); ++i) {
      if (w.counts[p.a].mask[i] != 0 || w.counts[p.b].mask[i] != 0) continue;
      of_a += w.counts[p.a].rate_dn_per_s[i] * kGain;
      of_b += w.counts[p.b].rate_dn_per_s[i] * kGain;
    }
    EXPECT_NEAR(p.u / std::sqrt(1 / of_a + 1 / of_b), 1, 2e-3) << "exposures " << p.a << " and " << p.b;
  }
}

TEST(Overlap, WithoutCommonPixelsTheStatedToleranceStays) {
  Optics s{{2.05, 0.97}, {2, 1}};
  World w = world(s, 7);
  for (std::size_t i = 0; i < w.counts[0].mask.size(); ++i) {
    if (i % 2 == 0)
      w.counts[0].mask[i] = kBad;
    else
      w.counts[1].mask[i] = w.counts[2].mask[i] = kBad;
  }
  const OverlapSolution o = solve(w);
  EXPECT_EQ(o.shift[0], 0);
  EXPECT_NEAR(std::sqrt(o.covariance(0, 0)), 0.1 / std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(o.shift[1], -0.03, 2e-3);  // exposures 2 and 3 still overlap
}

TEST(Overlap, ALeakIsReportedAndNotAveraged) {
  Optics s{{2.03, 0.98}, {2, 1}};
  s.leak_e = 60;  // light past the filters of the OD 2 exposure
  s.leaky = 0;
  const OverlapSolution o = solve(world(s, 8));
  int reported = 0;
  for (const OverlapPair& p : o.pairs) {
    if (p.problem.empty()) continue;
    ++reported;
    EXPECT_EQ(p.a, 0u);
    EXPECT_FALSE(p.used);
  }
  EXPECT_GE(reported, 1);
  EXPECT_NEAR(o.shift[1], -0.02, 2e-3);            // the good pair
  EXPECT_GE(std::sqrt(o.covariance(0, 0)), 0.02);  // the bad filter stays as uncertain as it was stated
}

TEST(Overlap, EqualStacksMustAgreeWithTheirTimes) {
  Optics s{{2.0, 1.0}, {2, 1}};
  World w = world(s, 9);
  s.time_error[1] = 0.02;
  World other = world(s, 10);
  w.counts[2] = other.counts[1];  // the same stack again, 2 % longer than stated
  w.scaled[2] = {&w.counts[2], w.scaled[1].factor, 2};
  w.causes.sensitivity.row(2) = w.causes.sensitivity.row(1);
  const OverlapSolution o = solve(w);
  bool found = false;
  for (const OverlapPair& p : o.pairs) found = found || (p.a == 1 && p.b == 2 && !p.problem.empty());
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace scatmap
