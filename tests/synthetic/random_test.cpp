// The random numbers against exact distributions: chi² of normal and Poisson draws with fixed seeds, moments where a
// histogram is too wide, and correlation between neighbouring streams. Does not prove that the generator passes a full
// battery (SplitMix64's published results are relied on), nor anything about probabilities below 1e-6.
#include "data-synthetic/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace scatmap::synth {
namespace {

// Deviate of a chi² from its expectation in standard deviations (Wilson and Hilferty's cube root).
double chi2_deviate(double chi2, double degrees) {
  const double v = 2 / (9 * degrees);
  return (std::cbrt(chi2 / degrees) - (1 - v)) / std::sqrt(v);
}

double deviate_of_histogram(const std::vector<double>& seen, const std::vector<double>& expected) {
  double chi2 = 0, degrees = -1;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    chi2 += (seen[i] - expected[i]) * (seen[i] - expected[i]) / expected[i];
    degrees += 1;
  }
  return chi2_deviate(chi2, degrees);
}

// Exact probabilities of 0 … last, and the rest; bins of less than 20 expected draws are joined with their neighbours.
double poisson_deviate(double mean, std::uint64_t draws) {
  const auto last = static_cast<std::size_t>(mean + 12 * std::sqrt(mean) + 20);
  std::vector<double> count(last + 1, 0);
  for (std::uint64_t i = 0; i < draws; ++i) {
    const double k = PixelRandom(random_key(7, 1, 3), i).poisson(mean);
    count[std::min(static_cast<std::size_t>(k), last)] += 1;
  }
  std::vector<double> seen{0}, expected{0};
  for (std::size_t k = 0; k <= last; ++k) {
    if (expected.back() >= 20) {
      seen.push_back(0);
      expected.push_back(0);
    }
    const long double log_p = static_cast<long double>(k) * std::log(static_cast<long double>(mean)) - mean -
                              std::lgamma(static_cast<long double>(k) + 1);
    seen.back() += count[k];
    expected.back() += static_cast<double>(std::exp(log_p)) * static_cast<double>(draws);
  }
  if (expected.back() < 20) {
    seen[seen.size() - 2] += seen.back();
    expected[expected.size() - 2] += expected.back();
    seen.pop_back();
    expected.pop_back();
  }
  return deviate_of_histogram(seen, expected);
}

TEST(Random, PoissonFollowsItsProbabilities) {
  for (const double mean : {0.025, 0.5, 1.0, 3.7, 9.99, 10.0, 10.5, 17.0, 60.0, 400.0, 5000.0}) {
    EXPECT_LE(std::fabs(poisson_deviate(mean, 400000)), 4.5) << mean;
  }
}

TEST(Random, PoissonMomentsOfLargeMeans) {
  for (const double mean : {1e5, 4e8, 1e12}) {
    constexpr int kDraws = 200000;
    double sum = 0, squares = 0;
    for (std::uint64_t i = 0; i < kDraws; ++i) {
      const double z = (PixelRandom(random_key(9, 1, 0), i).poisson(mean) - mean) / std::sqrt(mean);
      sum += z;
      squares += z * z;
    }
    EXPECT_LE(std::fabs(sum / kDraws), 4.5 / std::sqrt(kDraws)) << mean;
    EXPECT_LE(std::fabs(squares / kDraws - 1), 4.5 * std::sqrt(2.0 / kDraws)) << mean;
  }
}

TEST(Random, PoissonOfNothingIsZero) {
  PixelRandom random(1, 1);
  EXPECT_EQ(random.poisson(0), 0);
  EXPECT_EQ(random.poisson(-1), 0);
  EXPECT_EQ(random.poisson(std::nan("")), 0);
}

TEST(Random, NormalFollowsItsDensity) {
  constexpr std::uint64_t kDraws = 4000000;
  constexpr int kBins = 90;  // 0.1 wide from −4.5 to 4.5, and two tails
  std::vector<double> seen(kBins + 2, 0), expected(kBins + 2, 0);
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const double z = PixelRandom(random_key(11, 2, 0), i).normal();
    seen[static_cast<std::size_t>(std::clamp(std::floor((z + 4.5) / 0.1), -1.0, kBins + 0.0) + 1)] += 1;
  }
  const auto below = [](double z) { return std::erfc(-z / std::sqrt(2.0)) / 2; };
  for (int i = 0; i < kBins + 2; ++i) {
    const double low = i == 0 ? 0 : below(-4.5 + 0.1 * (i - 1)), high = i == kBins + 1 ? 1 : below(-4.5 + 0.1 * i);
    expected[static_cast<std::size_t>(i)] = (high - low) * kDraws;
  }
  EXPECT_LE(std::fabs(deviate_of_histogram(seen, expected)), 4.5);
}

TEST(Random, NormalMoments) {
  constexpr int kDraws = 4000000;
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0;
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const double z = PixelRandom(random_key(13, 2, 5), i).normal();
    m1 += z / kDraws;
    m2 += z * z / kDraws;
    m3 += z * z * z / kDraws;
    m4 += z * z * z * z / kDraws;
  }
  const double sigma = 1 / std::sqrt(kDraws);
  EXPECT_LE(std::fabs(m1), 4.5 * sigma);
  EXPECT_LE(std::fabs(m2 - 1), 4.5 * sigma * std::sqrt(2.0));
  EXPECT_LE(std::fabs(m3), 4.5 * sigma * std::sqrt(15.0));
  EXPECT_LE(std::fabs(m4 - 3), 4.5 * sigma * std::sqrt(96.0));
}

TEST(Random, NeighbouringStreamsAreUncorrelated) {
  constexpr int kDraws = 1000000;
  const auto draw = [](std::uint64_t seed, std::uint64_t purpose, std::uint64_t frame, std::uint64_t pixel) {
    return PixelRandom(random_key(seed, purpose, frame), pixel).normal();
  };
  double pixels = 0, frames = 0, seeds = 0, purposes = 0;
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const double z = draw(1, 1, 0, i);
    pixels += z * draw(1, 1, 0, i + 1) / kDraws;
    frames += z * draw(1, 1, 1, i) / kDraws;
    seeds += z * draw(2, 1, 0, i) / kDraws;
    purposes += z * draw(1, 2, 0, i) / kDraws;
  }
  for (const double correlation : {pixels, frames, seeds, purposes}) {
    EXPECT_LE(std::fabs(correlation), 4.5 / std::sqrt(kDraws));
  }
}

}  // namespace
}  // namespace scatmap::synth
