
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "scatmap/base/parallel.h"
#include "scatmap/brdf/scale_statistics.h"

namespace scatmap {
namespace {

constexpr std::size_t kBlock = 10'000;  // JCGM 101, 7.9.4: max(100/(1 − 0.95), 10^4)

// The mixing function of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
std::uint64_t mixed(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

// What a trial draws: rectangular parts, and all normal causes as the one normal that their sum is.
struct Draws {
  std::vector<double> width;  // of a rectangular part on ln F: value = offset + Σ width·(u − 1/2)
  double offset = 0;
  double normal = 0;  // standard deviation on ln F
  double relative_normal = 0;
  std::uint64_t key = 0;
};

Draws draws_of(const ScaleBudget& budget, double relative_normal, std::uint64_t seed) {
  Draws out;
  out.relative_normal = relative_normal;
  out.key = mixed(seed + 0x9e3779b97f4a7c15ULL);
  ScaleBudget normals = budget;
  for (ScaleCause& c : normals.causes) {
    const double half = c.sensitivity * c.half_width;
    switch (c.distribution) {
      case Distribution::kNormal:
        continue;
      case Distribution::kRectangular:
        out.width.push_back(2 * half);
        break;
      case Distribution::kTriangular:
        out.width.insert(out.width.end(), 2, half);
        break;
      case Distribution::kAsymmetric: {
        const double below = c.sensitivity * c.half_width_below;
        out.width.push_back(half + below);
        out.offset += (half - below) / 2;
      }
    }
    c.sensitivity = 0;
  }
  out.normal = normals.standard();
  return out;
}

// ln of a trial's rectangular parts, two from each 64 bits.
void rectangular_parts(const Draws& d, std::size_t first_trial, std::span<double> ln_factor) {
  constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ULL;
  std::fill(ln_factor.begin(), ln_factor.end(), d.offset);
  for (std::size_t j = 0; j < d.width.size(); j += 2) {
    const double first = d.width[j] * 0x1p-32, second = j + 1 < d.width.size() ? d.width[j + 1] * 0x1p-32 : 0;
    const double centre = (first + second) * (0x1p31 - 0.5);
    const std::uint64_t key = mixed(d.key + 1 + j);
    for (std::size_t i = 0; i < ln_factor.size(); ++i) {
      const std::uint64_t bits = mixed(key + (first_trial + i) * kStep);
      ln_factor[i] += first * static_cast<double>(static_cast<std::uint32_t>(bits)) +
                      second * static_cast<double>(static_cast<std::uint32_t>(bits >> 32)) - centre;
    }
  }
}

// F of the trials of a block. Box-Muller gives both normals of a trial at once.
void block_of_trials(const Draws& d, std::size_t first_trial, std::vector<double>& factor) {
  rectangular_parts(d, first_trial, factor);
  const bool any_normal = d.normal > 0 || d.relative_normal > 0;
  const std::uint64_t key = mixed(d.key);
  for (std::size_t i = 0; i < factor.size(); ++i) {
    if (!any_normal) {
      factor[i] = std::exp(factor[i]);
      continue;
    }
    const std::uint64_t bits = mixed(key + (first_trial + i) * 0x9e3779b97f4a7c15ULL);
    const double radius =
        std::sqrt(-2 * std::log((static_cast<double>(static_cast<std::uint32_t>(bits)) + 0.5) * 0x1p-32));
    const double angle =
        (static_cast<double>(static_cast<std::uint32_t>(bits >> 32)) + 0.5) * (0x1p-31 * std::numbers::pi);
    factor[i] = std::exp(factor[i] + d.normal * radius * std::cos(angle));
    if (d.relative_normal > 0) factor[i] *= 1 + d.relative_normal * radius * std::sin(angle);
  }
}

// Counts of F in equal bins over three times the range of a first block; what lies beyond is in the outermost bins.
// Where F spreads over decades, bins that resolve its standard deviation would not resolve its lower end: they are
// then equal in asinh(F/small), which is a logarithm on either side of 0.
struct Histogram {
  static constexpr std::size_t kBins = std::size_t{1} << 16;
  double low = 0, width = 0;
  double small = 0;  // 0: bins equal in F
  std::vector<std::uint32_t> count = std::vector<std::uint32_t>(kBins, 0);
  std::size_t total = 0;
  double sum = 0, square = 0;  // of F − 1

  double place(double f) const { return small > 0 ? std::asinh(f / small) : f; }
  double factor_at(double x) const { return small > 0 ? small * std::sinh(x) : x; }
  void add(const std::vector<double>& factor) {
    const double inverse = 1 / width;
    for (const double f : factor) {
      const double bin = std::clamp((place(f) - low) * inverse, 0.0, static_cast<double>(kBins - 1));
      ++count[static_cast<std::size_t>(bin)];
      sum += f - 1;
      square += (f - 1) * (f - 1);
    }
    total += factor.size();
  }
  void add(const Histogram& other) {
    for (std::size_t i = 0; i < kBins; ++i) count[i] += other.count[i];
    total += other.total;
    sum += other.sum;
    square += other.square;
  }
};

double standard_of_ln(const Draws& d) {
  double variance = d.normal * d.normal;
  for (const double w : d.width) variance += w * w / 12;
  return std::sqrt(variance);
}

Histogram empty_histogram(const Draws& d) {
  std::vector<double> pilot(kBlock);
  block_of_trials(d, 0, pilot);
  const auto [low, high] = std::minmax_element(pilot.begin(), pilot.end());
  Histogram out;
  constexpr double kWide = 0.7;  // of ln F
  if (const double u = standard_of_ln(d); u > kWide) out.small = 0.01 * std::exp(-4 * u);
  const double first = out.place(*low), span = std::max(out.place(*high) - first, 1e-12);
  out.low = first - span;
  out.width = 3 * span / static_cast<double>(Histogram::kBins);
  return out;
}

FactorStatistics statistics_of(const Histogram& h) {
  const double n = static_cast<double>(h.total);
  std::vector<double> below(Histogram::kBins + 1, 0);  // cumulated counts at the bins' edges
  for (std::size_t i = 0; i < Histogram::kBins; ++i) below[i + 1] = below[i] + h.count[i];
  const auto quantile = [&](double p) {
    const auto edge = static_cast<std::size_t>(std::upper_bound(below.begin(), below.end(), p * n) - below.begin());
    const std::size_t bin = std::clamp<std::size_t>(edge, 1, Histogram::kBins) - 1;
    const double part = h.count[bin] > 0 ? (p * n - below[bin]) / h.count[bin] : 0;
    return h.factor_at(h.low + (static_cast<double>(bin) + std::clamp(part, 0.0, 1.0)) * h.width);
  };
  FactorStatistics out;
  out.mean = 1 + h.sum / n;
  out.sd = std::sqrt(std::max(0.0, (h.square - h.sum * h.sum / n) / (n - 1)));
  out.symmetric = {quantile(0.025), quantile(0.975)};
  out.shortest = out.symmetric;
  constexpr int kSteps = 500;
  for (int i = 0; i <= kSteps; ++i) {
    const double p = 0.05 * i / kSteps;
    const FactorInterval candidate{quantile(p), quantile(std::min(1.0, p + 0.95))};
    if (candidate.high - candidate.low < out.shortest.high - out.shortest.low) out.shortest = candidate;
  }
  return out;
}

// What one block says, for the stopping rule.
using BlockEstimate = std::array<double, 4>;

BlockEstimate estimate(std::vector<double>& factor) {
  double sum = 0, square = 0;
  for (const double f : factor) {
    sum += f - 1;
    square += (f - 1) * (f - 1);
  }
  const double n = static_cast<double>(factor.size());
  const auto at = [&](double p) {
    const auto place = factor.begin() + static_cast<std::ptrdiff_t>(p * n);
    std::nth_element(factor.begin(), place, factor.end());
    return *place;
  };
  const double low = at(0.025), high = at(0.975);
  return {sum / n, std::sqrt((square - sum * sum / n) / (n - 1)), low, high};
}

struct RunningMean {
  std::array<double, 4> sum{}, square{};
  double count = 0;

  void add(const BlockEstimate& e) {
    for (std::size_t k = 0; k < e.size(); ++k) {
      sum[k] += e[k];
      square[k] += e[k] * e[k];
    }
    count += 1;
  }
  // Twice the standard deviation of the mean of the blocks, of the worst of the four.
  double twice_deviation() const {
    double worst = 0;
    for (std::size_t k = 0; k < sum.size(); ++k) {
      const double variance = std::max(0.0, square[k] - sum[k] * sum[k] / count) / (count - 1) / count;
      worst = std::max(worst, 2 * std::sqrt(variance));
    }
    return worst;
  }
};

}  // namespace

FactorStatistics monte_carlo(const ScaleBudget& budget, double relative_normal, std::size_t trials,
                             std::uint64_t seed) {
  const Draws d = draws_of(budget, relative_normal, seed);
  if (d.width.empty() && d.normal == 0 && relative_normal == 0) return {};
  const std::size_t blocks = std::max<std::size_t>(1, (trials + kBlock - 1) / kBlock);
  constexpr std::size_t kParts = 8;  // fixed, so that sums do not depend on the number of threads
  std::vector<Histogram> parts(kParts, empty_histogram(d));
  for_each_index(kParts, std::size_t{1}, [&](std::size_t part) {
    for (std::size_t b = part; b < blocks; b += kParts) {
      std::vector<double> factor(std::min(kBlock, trials - b * kBlock));
      block_of_trials(d, b * kBlock, factor);
      parts[part].add(factor);
    }
  });
  for (std::size_t part = 1; part < kParts; ++part) parts[0].add(parts[part]);
  return statistics_of(parts[0]);
}

AdaptiveResult adaptive_monte_carlo(const ScaleBudget& budget, double relative_normal, double tolerance,
                                    std::uint64_t seed) {
  AdaptiveResult out{{}, 0, tolerance, false};
  const Draws d = draws_of(budget, relative_normal, seed);
  if (d.width.empty() && d.normal == 0 && relative_normal == 0) return {{}, 0, tolerance, true};
  Histogram all = empty_histogram(d);
  RunningMean mean;
  constexpr std::size_t kBatch = 32;  // blocks between two looks at the stopping rule
  std::vector<std::vector<double>> factors(kBatch, std::vector<double>(kBlock));
  std::array<BlockEstimate, kBatch> estimates;
  while (!out.converged && out.trials < kMostTrials) {
    for_each_index(kBatch, std::size_t{1}, [&](std::size_t b) {
      block_of_trials(d, out.trials + b * kBlock, factors[b]);
      estimates[b] = estimate(factors[b]);
    });
    for (std::size_t b = 0; b < kBatch; ++b) {
      all.add(factors[b]);
      mean.add(estimates[b]);
    }
    out.trials += kBatch * kBlock;
    out.converged = mean.twice_deviation() <= tolerance;
  }
  out.factor = statistics_of(all);
  return out;
}

}  // namespace scatmap
