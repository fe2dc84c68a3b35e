#include "scatmap/brdf/overlap.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "scatmap/brdf/overlap_sums.h"

namespace scatmap {
namespace {

constexpr int kMostRounds = 8;
constexpr double kConverged = 1e-6;  // of any ln factor
constexpr double kMarginSigmas = 4;  // of the present knowledge of a ratio: a difference within them is no outlier

std::vector<PairIndex> pairs_of(std::size_t first, std::size_t exposures) {
  std::vector<PairIndex> out;
  for (std::size_t a = 0; a < exposures; ++a) {
    for (std::size_t b = a + 1; b < exposures; ++b) out.push_back({first + a, first + b});
  }
  return out;
}

std::vector<PairIndex> all_pairs(std::span<const OverlapGroup> groups) {
  std::vector<PairIndex> out;
  std::size_t first = 0;
  for (const OverlapGroup& g : groups) {
    const std::vector<PairIndex> own = pairs_of(first, g.exposures.size());
    out.insert(out.end(), own.begin(), own.end());
    first += g.exposures.size();
  }
  return out;
}

// Everything that does not change from round to round.
struct Problem {
  std::span<const OverlapGroup> groups;
  const ExposureCauses& causes;
  double u_nonlinearity;
  std::vector<PairIndex> pairs;  // group by group
  Eigen::MatrixXd rows;          // d ln factor / d cause, exposures of all groups

  Eigen::Index unknowns() const { return rows.cols(); }
  Eigen::MatrixXd prior() const { return causes.variances().asDiagonal(); }
  // d ln ratio / d cause: one row per pair.
  Eigen::MatrixXd design() const {
    Eigen::MatrixXd out(static_cast<Eigen::Index>(pairs.size()), unknowns());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      out.row(static_cast<Eigen::Index>(k)) =
          rows.row(static_cast<Eigen::Index>(pairs[k].a)) - rows.row(static_cast<Eigen::Index>(pairs[k].b));
    }
    return out;
  }
};

std::vector<ScaledCounts> scaled(const OverlapGroup& group, const Eigen::VectorXd& ln_factor) {
  std::vector<ScaledCounts> out(group.exposures.begin(), group.exposures.end());
  for (std::size_t e = 0; e < out.size(); ++e) out[e].factor *= std::exp(ln_factor[static_cast<Eigen::Index>(e)]);
  return out;
}

// A pixel's level is its counts, whatever the factor: per unit of the map it falls as the factor grows.
std::vector<double> levels(const OverlapGroup& group, const Eigen::VectorXd& ln_factor) {
  std::vector<double> out(group.level_per_unit.begin(), group.level_per_unit.end());
  for (std::size_t e = 0; e < out.size(); ++e) out[e] *= std::exp(-ln_factor[static_cast<Eigen::Index>(e)]);
  return out;
}

// Pairs of two groups share no light and no noise.
PairSums joined(const PairSums& a, const PairSums& b) {
  const auto stacked = [](const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
    Eigen::VectorXd out(x.size() + y.size());
    out << x, y;
    return out;
  };
  PairSums out{stacked(a.ln_ratio, b.ln_ratio),
               Eigen::MatrixXd::Zero(a.ln_ratio.size() + b.ln_ratio.size(), a.ln_ratio.size() + b.ln_ratio.size()),
               stacked(a.level, b.level),
               stacked(a.pixels, b.pixels),
               stacked(a.chi_squared, b.chi_squared),
               stacked(a.level_difference, b.level_difference),
               stacked(a.u_level_difference, b.u_level_difference)};
  out.covariance.topLeftCorner(a.covariance.rows(), a.covariance.cols()) = a.covariance;
  out.covariance.bottomRightCorner(b.covariance.rows(), b.covariance.cols()) = b.covariance;
  return out;
}

// All pairs of all groups, with the factors of the present shift.
PairSums sums_of(const Problem& p, const Eigen::VectorXd& shift, const Eigen::VectorXd& margins) {
  const Eigen::VectorXd ln_factor = p.rows * shift;
  PairSums out;
  Eigen::Index exposure = 0, pair = 0;
  for (const OverlapGroup& g : p.groups) {
    const auto count = static_cast<Eigen::Index>(g.exposures.size());
    const std::vector<PairIndex> pairs = pairs_of(0, g.exposures.size());
    const std::vector<ScaledCounts> now = scaled(g, ln_factor.segment(exposure, count));
    if (!pairs.empty()) {
      out = joined(out, pair_sums(now, merge_once(now), pairs, levels(g, ln_factor.segment(exposure, count)),
                                  p.u_nonlinearity, margins.segment(pair, static_cast<Eigen::Index>(pairs.size()))));
    }
    exposure += count;
    pair += static_cast<Eigen::Index>(pairs.size());
  }
  return out;
}

// What one round measured, per pair.
struct Measured {
  Eigen::MatrixXd design;
  Eigen::VectorXd value;         // of design · cause
  Eigen::MatrixXd noise;         // covariance of the values, counting alone
  Eigen::VectorXd nonlinearity;  // change of a value at one standard deviation of the non-linearity
};

struct Update {
  Eigen::VectorXd shift;
  Eigen::MatrixXd covariance;  // of the causes and, last, the non-linearity
  Eigen::VectorXd residual, u_residual;
};

// Least squares with priors, in the form that needs no inverse of a singular prior (a cause stated as exact). The
// non-linearity is not estimated from overlaps (the map is not corrected for it) but considered: it disturbs the
// values, and so the estimates' errors correlate with it.
Update update(const Problem& p, const Measured& m, const std::vector<Eigen::Index>& used) {
  const Eigen::MatrixXd prior = p.prior(), a = m.design(used, Eigen::all);
  const Eigen::VectorXd n = m.nonlinearity(used), y = m.value(used);
  const Eigen::MatrixXd floor = Eigen::MatrixXd::Identity(a.rows(), a.rows()) * (kBestRatio * kBestRatio);
  const Eigen::MatrixXd sigma = m.noise(used, used) + floor + n * n.transpose(),
                        innovation = a * prior * a.transpose() + sigma;
  const Eigen::LDLT<Eigen::MatrixXd> solver(innovation);
  const Eigen::MatrixXd gain = solver.solve(a * prior).transpose();
  const Eigen::MatrixXd keep = Eigen::MatrixXd::Identity(p.unknowns(), p.unknowns()) - gain * a;
  const Eigen::Index count = p.unknowns();
  Update out{gain * y, Eigen::MatrixXd::Identity(count + 1, count + 1), y - a * gain * y, {}};
  out.covariance.topLeftCorner(count, count) = keep * prior * keep.transpose() + gain * sigma * gain.transpose();
  out.covariance.col(count).head(count) = -gain * n;
  out.covariance.row(count).head(count) = out.covariance.col(count).head(count).transpose();
  out.u_residual = (sigma * solver.solve(sigma)).diagonal().cwiseMax(0).cwiseSqrt();
  return out;
}

Update nothing_learned(const Problem& p) {
  const Eigen::Index count = p.unknowns();
  Update out{Eigen::VectorXd::Zero(count), Eigen::MatrixXd::Identity(count + 1, count + 1), {}, {}};
  out.covariance.topLeftCorner(count, count) = p.prior();
  return out;
}

std::string text(const char* format, double a, double b) {
  char out[200];
  std::snprintf(out, sizeof out, format, a, b);
  return out;
}

// Tests of a pair by itself.
void judge(OverlapPair& pair) {
  const double chi_bound = 1 + kChiSquaredAllowance + kOverlapSigmas * std::sqrt(2 / std::max(1.0, pair.pixels));
  if (!(pair.chi_squared <= chi_bound)) {
    pair.problem =
        text("their pixels scatter by chi-squared %.2f per pixel, more than %.2f", pair.chi_squared, chi_bound);
  }
  const double bound = kRatioAllowance + kOverlapSigmas * pair.u_level_difference;
  if (!(std::abs(pair.level_difference) <= bound)) {
    pair.problem = text(
        "their ratio differs by %.3g %% between bright and dim pixels, more than %.3g %% (leak, ghost or "
        "non-linearity)",
        100 * pair.level_difference, 100 * bound);
  }
}

OverlapPair describe(const PairSums& sums, const PairIndex& index, Eigen::Index k) {
  OverlapPair out{index.a,
                  index.b,
                  sums.ln_ratio[k],
                  std::sqrt(sums.covariance(k, k)),
                  sums.pixels[k],
                  sums.chi_squared[k],
                  sums.level_difference[k],
                  sums.u_level_difference[k],
                  true,
                  {}};
  constexpr double kFewest = 20;
  out.used = out.pixels >= kFewest && out.u <= kWorstUsefulRatio && std::isfinite(out.ln_ratio);
  return out;
}

std::vector<Eigen::Index> used_pairs(const std::vector<OverlapPair>& pairs) {
  std::vector<Eigen::Index> out;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (pairs[k].used) out.push_back(static_cast<Eigen::Index>(k));
  }
  return out;
}

// Leaves out, one after the other, the pair that fits the others and the stated tolerances worst.
Update solve_consistently(const Problem& p, const Measured& m, std::vector<OverlapPair>& pairs) {
  for (;;) {
    const std::vector<Eigen::Index> used = used_pairs(pairs);
    if (used.empty()) return nothing_learned(p);
    const Update u = update(p, m, used);
    double worst = 1;
    std::size_t which = pairs.size();
    for (Eigen::Index i = 0; i < u.residual.size(); ++i) {
      const double over = std::abs(u.residual[i]) / (kRatioAllowance + kOverlapSigmas * u.u_residual[i]);
      if (!(over > worst)) continue;
      worst = over;
      which = static_cast<std::size_t>(used[static_cast<std::size_t>(i)]);
    }
    if (which == pairs.size()) return u;
    pairs[which].used = false;
    pairs[which].problem = text(
        "their ratio contradicts the other exposures or the stated times and tolerances by %.3g %%, %.1f times the "
        "bound",
        100 * pairs[which].ln_ratio, worst);
  }
}

// Relative difference of each pair that is no outlier, as well as its ratio is known.
Eigen::VectorXd margins(const Problem& p, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd design = p.design();
  const Eigen::MatrixXd known = covariance.topLeftCorner(p.unknowns(), p.unknowns());
  const Eigen::VectorXd u = (design * known * design.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
  return (kMarginSigmas * u).array().exp() - 1 + kMarginSigmas * p.u_nonlinearity;
}

// One round: merge with the present factors, measure all pairs, test them, solve.
Update one_round(const Problem& p, const Update& present, bool with_tests, std::vector<OverlapPair>& pairs) {
  const PairSums sums = sums_of(p, present.shift, margins(p, present.covariance));
  pairs.clear();
  for (std::size_t k = 0; k < p.pairs.size(); ++k) {
    pairs.push_back(describe(sums, p.pairs[k], static_cast<Eigen::Index>(k)));
    if (with_tests && pairs.back().used) judge(pairs.back());
    pairs.back().used = pairs.back().used && pairs.back().problem.empty();
  }
  const Eigen::MatrixXd design = p.design();
  // With the present shift s the ratio of values is exp(−A(θ − s)).
  return solve_consistently(
      p, {design, design * present.shift - sums.ln_ratio, sums.covariance, p.u_nonlinearity * sums.level}, pairs);
}

}  // namespace

std::string pair_name(const OverlapPair& p, std::size_t sample_exposures) {
  const bool beam = p.a >= sample_exposures;
  const std::size_t first = beam ? sample_exposures : 0;
  return std::string(beam ? "signature " : "") + "exposures " + std::to_string(p.a - first + 1) + " and " +
         std::to_string(p.b - first + 1);
}

OverlapSolution solve_overlap(std::span<const OverlapGroup> groups, const ExposureCauses& causes,
                              double u_nonlinearity) {
  const Problem p{groups, causes, u_nonlinearity, all_pairs(groups), causes.all_rows()};
  Update present = nothing_learned(p);
  std::vector<OverlapPair> pairs;
  for (int round = 0; round < kMostRounds; ++round) {
    // Before the factors have settled, pairs would fail for what the tolerances allow.
    const Update next = one_round(p, present, round >= 2, pairs);
    const double change = (p.rows * (next.shift - present.shift)).cwiseAbs().maxCoeff();
    present = next;
    if (round >= 3 && change < kConverged) break;
  }
  return {present.shift, present.covariance, std::move(pairs)};
}

}  // namespace scatmap
