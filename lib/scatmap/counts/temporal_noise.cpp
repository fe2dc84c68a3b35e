#include "scatmap/counts/temporal_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace scatmap {
namespace {

struct Pair {
  double mean = 0, variance = 0, values = 0;
};

// Differences further off than `limit` from `centre` are hits of one of the frames: the other is what counts.
Pair pair_within(const RawCounts& a, const RawCounts& b, const PixelUse& use, double centre, double limit) {
  double sum = 0, square = 0, both = 0, n = 0, pixels = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double x = a[i], y = b[i], d = x - y;
    if (!use[i] || std::isnan(d)) continue;
    const bool hit = std::abs(d - centre) > limit;
    pixels += 1;
    both += hit ? 2 * std::min(x, y) : x + y;
    if (hit) continue;
    sum += d;
    square += (d - centre) * (d - centre);
    n += 1;
  }
  const double off = sum / n - centre;
  return {both / pixels / 2, (square - n * off * off) / (n - 1) / 2, n};
}

// The spatial pattern cancels in the difference of two frames, its mean is drift of the light.
Pair pair_of(const RawCounts& a, const RawCounts& b, const PixelUse& use) {
  std::vector<double> differences;
  differences.reserve(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = static_cast<double>(a[i]) - b[i];
    if (use[i] && !std::isnan(d)) differences.push_back(d);
  }
  if (differences.empty()) return {std::nan(""), std::nan(""), 0};
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  const double centre = *middle;
  Pair pair = pair_within(a, b, use, centre, std::numeric_limits<double>::infinity());
  for (double before = 0; pair.values != before;) {
    before = pair.values;
    pair = pair_within(a, b, use, centre, kHitSigmas * std::sqrt(2 * pair.variance) + 0.5);
  }
  return pair;
}

double mean_of(const RawCounts& dn, const PixelUse& use) {
  double sum = 0, n = 0;
  for (std::size_t i = 0; i < dn.size(); ++i) {
    if (!use[i] || std::isnan(dn[i])) continue;
    sum += dn[i];
    n += 1;
  }
  return sum / n;
}

}  // namespace

double TemporalNoise::u_variance() const { return variance * std::sqrt(2 / values); }

TemporalNoise temporal_noise(std::span<const Frame> frames, const PixelUse& use) {
  TemporalNoise out;
  double pairs = 0, count = 0;
  for (std::size_t k = 0; k + 1 < frames.size(); k += 2) {
    const Pair pair = pair_of(frames[k].dn, frames[k + 1].dn, use);
    out.mean += 2 * pair.mean;
    out.variance += pair.variance;
    out.values += pair.values - 1;
    pairs += 1;
    count += 2;
  }
  if (frames.size() % 2 == 1) {
    out.mean += mean_of(frames.back().dn, use);
    count += 1;
  }
  out.mean /= count;
  out.variance /= pairs;
  return out;
}

}  // namespace scatmap
