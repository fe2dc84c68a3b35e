// u_random against simulated frames with darks, from no light to half of full scale, uniform and on a broad lobe: what
// is claimed is what is observed. Does not prove that a real sensor's noise is Poisson and Gaussian.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "data-synthetic/render.h"
#include "scatmap/brdf/merge.h"

namespace scatmap {
namespace {

constexpr int kSide = 64, kSeeds = 80;
constexpr double kExposure_s = 5;

// Claimed over observed standard deviation within this, beside three standard errors.
constexpr double kRandomClaim = 0.002;

class RandomClaim : public testing::TestWithParam<double> {
 protected:
  Counts simulated(const Grid<double>& signal_e, std::uint64_t seed) {
    synth::SensorTruth truth;
    truth.gain_e_per_dn = 1.5;
    truth.read_noise_e = 8;
    truth.bias_dn = 300;
    truth.dark_e_per_s = 2;
    std::uint64_t number = 0;
    const auto frames = [&](int count, const Grid<double>& e) {
      std::vector<Frame> out;
      for (int k = 0; k < count; ++k) {
        const Grid<std::uint16_t> dn = synth::render_frame(e, truth, kExposure_s, {seed, number++});
        out.push_back({Grid<float>(kSide, kSide), 1, "simulated", {}});
        for (std::size_t i = 0; i < dn.size(); ++i) out.back().dn[i] = dn[i];
      }
      return out;
    };
    const SensorModel sensor{1.5, 8, 60000, 300, {}};
    return reduce(frames(3, signal_e), combine_darks(frames(4, Grid<double>(kSide, kSide, 0.0)), sensor), sensor, {},
                  kExposure_s);
  }

  void expect_honest(const Grid<double>& signal_e, double from_e, std::uint64_t first_seed) {
    double n = 0, square = 0, fourth = 0;
    for (std::uint64_t seed = first_seed; seed < first_seed + kSeeds; ++seed) {
      const Counts counts = simulated(signal_e, seed);
      const Merged m = merge(std::vector<ScaledCounts>{{&counts, 1, 0}});
      for (std::size_t i = 0; i < signal_e.size(); ++i) {
        if (m.mask[i] != 0 || signal_e[i] < from_e) continue;
        const double error = m.value[i] - signal_e[i] / 1.5 / kExposure_s;
        const double z2 = error * error / static_cast<double>(m.variance[i]);
        n += 1;
        square += z2;
        fourth += z2 * z2;
      }
    }
    const double variance = square / n, se = std::sqrt((fourth / n - variance * variance) / n) / (2 * variance);
    std::printf("claimed/observed %.4f, standard error %.4f\n", 1 / std::sqrt(variance), se);
    EXPECT_NEAR(1 / std::sqrt(variance), 1, kRandomClaim + 3 * se);
  }
};

TEST_P(RandomClaim, UniformLight) { expect_honest(Grid<double>(kSide, kSide, GetParam()), 0, 1); }

TEST_P(RandomClaim, BroadLobe) {
  Grid<double> e(kSide, kSide);
  for (int r = 0; r < kSide; ++r) {
    for (int c = 0; c < kSide; ++c)
      e(r, c) = GetParam() * std::exp(-(std::pow(r - 31.5, 2) + std::pow(c - 31.5, 2)) / 128);
  }
  expect_honest(e, 0.05 * GetParam(), 500);
}

INSTANTIATE_TEST_SUITE_P(Electrons, RandomClaim, testing::Values(0.0, 3.0, 30.0, 300.0, 3000.0, 30000.0));

}  // namespace
}  // namespace scatmap
