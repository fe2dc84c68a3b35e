#include "scatmap/brdf/overlap_sums.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scatmap/base/parallel.h"
#include "scatmap/counts/expected_signal.h"

namespace scatmap {
namespace {

constexpr double kOutlierSigmas = 6;
// Where the neighbours predict less than this share of the noise of a − b, a pixel tells next to nothing.
constexpr double kFaintest = 0.05;

// Mean of the good pixels among the eight neighbours: knows nothing of the pixel's own noise. NaN without any.
double neighbour_mean(const Merged& merged, int row, int column) {
  double sum = 0, n = 0;
  for (int r = std::max(0, row - 1); r <= std::min(merged.mask.rows() - 1, row + 1); ++r) {
    for (int c = std::max(0, column - 1); c <= std::min(merged.mask.columns() - 1, column + 1); ++c) {
      if ((r == row && c == column) || merged.mask(r, c) != 0) continue;
      sum += merged.value(r, c);
      n += 1;
    }
  }
  return n > 0 ? sum / n : std::numeric_limits<double>::quiet_NaN();
}

// All exposures at one pixel, in map units. What weighs or rejects a pixel follows from the signal that its neighbours
// predict, in which its own noise has no part. What is summed follows from the pixel's own merged signal: on the flanks
// of a peak the neighbours' mean is on one side of the truth at every pixel, while noise averages out of the sums.
struct Pixel {
  std::vector<double> value, dark;
  std::vector<double> variance, own_variance;  // at the predicted and at the pixel's own signal
  std::vector<bool> good;
  double predicted = 0, own = 0;
};

void fill(std::span<const ScaledCounts> exposures, int row, int column, Pixel& p) {
  for (std::size_t e = 0; e < exposures.size(); ++e) {
    const Counts& c = *exposures[e].counts;
    const double f = exposures[e].factor;
    p.good[e] = c.mask(row, column) == 0;
    p.value[e] = c.rate_dn_per_s(row, column) * f;
    p.dark[e] = c.dark_floor(row, column) * f * f;
    const double floor = c.frame_floor(row, column) * f * f + p.dark[e], shot = c.shot(row, column) * f;
    p.variance[e] = floor + std::max(0.0, p.predicted) * shot;
    p.own_variance[e] = variance_at(p.own, floor, shot);
  }
}

double covariance(std::span<const ScaledCounts> exposures, const Pixel& p, const std::vector<double>& variance,
                  std::size_t i, std::size_t j) {
  if (i == j) return variance[i];
  return exposures[i].dark_group == exposures[j].dark_group ? std::sqrt(p.dark[i] * p.dark[j]) : 0;
}

// Σ over pixels for one pair; `part` 0: dimmer, 1: brighter half.
struct Sums {
  double a[2] = {0, 0}, b[2] = {0, 0}, noise[2] = {0, 0}, signal[2] = {0, 0}, level[2] = {0, 0};
  double pixels = 0, chi_squared = 0;

  void add(const Sums& other) {
    for (int part = 0; part < 2; ++part) {
      a[part] += other.a[part];
      b[part] += other.b[part];
      noise[part] += other.noise[part];
      signal[part] += other.signal[part];
      level[part] += other.level[part];
    }
    pixels += other.pixels;
    chi_squared += other.chi_squared;
  }
};

struct Accumulator {
  std::span<const ScaledCounts> exposures;
  std::span<const PairIndex> pairs;
  std::span<const double> level_per_unit;
  const Eigen::VectorXd& margin;
  double u_nonlinearity;
  std::vector<double> split;  // signal that parts the brighter from the dimmer half; 0 in the first round
  std::vector<Sums> sums;
  std::vector<double> moment, norm;  // of the signal, for `split`
  Eigen::MatrixXd covariance_sum;
  std::vector<double> weight;

  void add(const Accumulator& other) {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      sums[k].add(other.sums[k]);
      moment[k] += other.moment[k];
      norm[k] += other.norm[k];
    }
    covariance_sum += other.covariance_sum;
  }

  // Of the differences of two pairs' values, at the pixel's own signal.
  double difference_covariance(const Pixel& p, const PairIndex& first, const PairIndex& second) const {
    const auto [a, b] = first;
    const auto [c, d] = second;
    const auto of = [&](std::size_t i, std::size_t j) { return covariance(exposures, p, p.own_variance, i, j); };
    return of(a, c) - of(a, d) - of(b, c) + of(b, d);
  }

  int part_of(std::size_t k, const Pixel& p) const { return p.predicted >= split[k] ? 1 : 0; }

  void pair_at(std::size_t k, const Pixel& p) {
    weight[k] = 0;
    const auto [a, b] = pairs[k];
    if (!p.good[a] || !p.good[b]) return;
    const double mu = p.predicted;
    const double variance = p.variance[a] + p.variance[b] - 2 * covariance(exposures, p, p.variance, a, b);
    if (!(mu > kFaintest * std::sqrt(variance))) return;
    const double difference = p.value[a] - p.value[b];
    if (!(std::abs(difference) <= kOutlierSigmas * std::sqrt(variance) + margin[static_cast<Eigen::Index>(k)] * mu))
      return;
    const double w = mu / variance;
    weight[k] = w;
    Sums& s = sums[k];
    const int part = part_of(k, p);
    const double level = (level_per_unit[a] - level_per_unit[b]) * p.own, allowed = u_nonlinearity * level * mu;
    s.a[part] += w * p.value[a];
    s.b[part] += w * p.value[b];
    s.signal[part] += w * p.own;
    s.level[part] += w * p.own * level;
    s.pixels += 1;
    s.chi_squared += difference * difference / (variance + allowed * allowed);
    moment[k] += w * mu * mu;
    norm[k] += w * mu;
  }

  void add(const Pixel& p) {
    for (std::size_t k = 0; k < pairs.size(); ++k) pair_at(k, p);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (weight[k] == 0) continue;
      for (std::size_t l = 0; l <= k; ++l) {
        if (weight[l] == 0) continue;
        const double added = weight[k] * weight[l] * difference_covariance(p, pairs[k], pairs[l]);
        covariance_sum(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)) += added;
        if (l == k) sums[k].noise[part_of(k, p)] += added;
      }
    }
  }
};

void visit_rows(std::span<const ScaledCounts> exposures, const Merged& merged, int first, int last, Accumulator& out) {
  const std::size_t n = exposures.size();
  const std::vector<double> none(n);
  Pixel p{none, none, none, none, std::vector<bool>(n), 0, 0};
  for (int r = first; r < last; ++r) {
    for (int c = 0; c < merged.mask.columns(); ++c) {
      if (merged.mask(r, c) != 0) continue;
      p.predicted = neighbour_mean(merged, r, c);
      if (!(p.predicted > 0)) continue;
      p.own = merged.value(r, c);
      fill(exposures, r, c, p);
      out.add(p);
    }
  }
}

// @param out  empty sums. Bands of rows are summed apart and added in order, so that threads do not change the result.
void visit_pixels(std::span<const ScaledCounts> exposures, const Merged& merged, Accumulator& out) {
  constexpr int kBand = 64;
  const int rows = merged.mask.rows();
  std::vector<Accumulator> bands(static_cast<std::size_t>((rows + kBand - 1) / kBand), out);
  for_each_index(bands.size(), std::size_t{1}, [&](std::size_t i) {
    const int first = static_cast<int>(i) * kBand;
    visit_rows(exposures, merged, first, std::min(rows, first + kBand), bands[i]);
  });
  for (const Accumulator& band : bands) out.add(band);
}

PairSums finish(const Accumulator& acc) {
  const auto n = static_cast<Eigen::Index>(acc.pairs.size());
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(n);
  PairSums out{zero, Eigen::MatrixXd::Zero(n, n), zero, zero, zero, zero, zero};
  for (Eigen::Index k = 0; k < n; ++k) {
    const Sums& s = acc.sums[static_cast<std::size_t>(k)];
    const double signal = s.signal[0] + s.signal[1];
    out.ln_ratio[k] = std::log((s.a[0] + s.a[1]) / (s.b[0] + s.b[1]));
    out.level[k] = (s.level[0] + s.level[1]) / signal;
    out.pixels[k] = s.pixels;
    out.chi_squared[k] = s.chi_squared / s.pixels;
    out.level_difference[k] = std::log(s.a[1] / s.b[1]) - std::log(s.a[0] / s.b[0]);
    const double slope = acc.u_nonlinearity * (s.level[1] / s.signal[1] - s.level[0] / s.signal[0]);
    out.u_level_difference[k] =
        std::sqrt(s.noise[0] / (s.signal[0] * s.signal[0]) + s.noise[1] / (s.signal[1] * s.signal[1]) + slope * slope);
    for (Eigen::Index l = 0; l <= k; ++l) {
      const Sums& t = acc.sums[static_cast<std::size_t>(l)];
      out.covariance(k, l) = out.covariance(l, k) = acc.covariance_sum(k, l) / (signal * (t.signal[0] + t.signal[1]));
    }
  }
  return out;
}

}  // namespace

PairSums pair_sums(std::span<const ScaledCounts> exposures, const Merged& merged, std::span<const PairIndex> pairs,
                   std::span<const double> level_per_unit, double u_nonlinearity, const Eigen::VectorXd& margin) {
  const std::size_t n = pairs.size();
  const auto size = static_cast<Eigen::Index>(n);
  const auto fresh = [&](std::vector<double> split) {
    return Accumulator{exposures,
                       pairs,
                       level_per_unit,
                       margin,
                       u_nonlinearity,
                       std::move(split),
                       std::vector<Sums>(n),
                       std::vector<double>(n, 0),
                       std::vector<double>(n, 0),
                       Eigen::MatrixXd::Zero(size, size),
                       std::vector<double>(n, 0)};
  };
  Accumulator first = fresh(std::vector<double>(n, 0));
  visit_pixels(exposures, merged, first);
  std::vector<double> split(n);
  for (std::size_t k = 0; k < n; ++k) split[k] = first.moment[k] / first.norm[k];
  Accumulator second = fresh(std::move(split));
  visit_pixels(exposures, merged, second);
  return finish(second);
}

}  // namespace scatmap
