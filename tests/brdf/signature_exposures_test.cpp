// A beam in several exposures: the core that one saturates comes from the other, the sum is the beam's with the claimed
// sigma, shares and levels are what they say. Does not prove that the filters between the exposures are known: that is
// overlap_test.cpp's.
#include "scatmap/brdf/signature_exposures.h"

#include <gtest/gtest.h>

#include <random>

#include "scatmap/base/error.h"

namespace scatmap {
namespace {

constexpr int kSide = 80;
constexpr double kSigma_px = 5, kGain = 1.5, kRead_dn = 5, kBeam_dn_per_s = 4e6, kFull_dn = 50000;

// Counts of the beam through a filter of this transmittance; cut where they saturate.
Counts beam(double transmittance, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  Counts c{{kSide, kSide}, {kSide, kSide}, {kSide, kSide}, {kSide, kSide}, {kSide, kSide}, 1, 0, 0};
  for (int r = 0; r < kSide; ++r) {
    for (int k = 0; k < kSide; ++k) {
      const double d2 = std::pow(r - 39.3, 2) + std::pow(k - 40.6, 2);
      const double mean = transmittance * kBeam_dn_per_s / (2 * 3.14159265358979 * kSigma_px * kSigma_px) *
                          std::exp(-d2 / (2 * kSigma_px * kSigma_px));
      c.rate_dn_per_s(r, k) = mean + std::sqrt(mean / kGain + kRead_dn * kRead_dn) * normal(rng);
      c.frame_floor(r, k) = static_cast<float>(kRead_dn * kRead_dn);
      c.shot(r, k) = static_cast<float>(1 / kGain);
      c.dark_floor(r, k) = 0;
      c.mask(r, k) = mean > kFull_dn ? kSaturated : Mask{0};
    }
  }
  return c;
}

TEST(SignatureExposures, OneExposureIsMeasuredAsItIs) {
  const Counts c = beam(1, 1);
  const MergedSignature one = merge_signature(std::vector<ScaledCounts>{{&c, 1, 0}}, {});
  const Signature plain = measure_signature(c, {});
  EXPECT_EQ(one.beam.rate_dn_per_s, plain.rate_dn_per_s);
  EXPECT_EQ(one.beam.u_rate_dn_per_s, plain.u_rate_dn_per_s);
  EXPECT_EQ(one.share, std::vector<double>{1});
  EXPECT_NEAR(one.level_dn, kBeam_dn_per_s / (4 * 3.14159265358979 * kSigma_px * kSigma_px), 100);  // Gaussian: half
}

TEST(SignatureExposures, ASaturatedCoreComesFromTheOtherAndTheSumIsHonest) {
  constexpr int kTrials = 60;
  double square = 0, u = 0;
  for (std::uint64_t t = 0; t < kTrials; ++t) {
    const Counts weak = beam(1, 100 + t), bright = beam(10, 500 + t);
    ASSERT_THROW(measure_signature(bright, {}), Error);
    const MergedSignature m = merge_signature(std::vector<ScaledCounts>{{&weak, 1, 0}, {&bright, 0.1, 1}}, {});
    const double z = (m.beam.rate_dn_per_s - kBeam_dn_per_s) / m.beam.u_rate_dn_per_s;
    square += z * z;
    u = m.beam.u_rate_dn_per_s;
    EXPECT_NEAR(m.share[0] + m.share[1], 1, 1e-12);
    EXPECT_GT(m.share[0], 0.5);  // the core, beyond 50000 of 255000 DN, is the weak exposure's alone
    EXPECT_GT(m.share[1], 0.1);
  }
  EXPECT_NEAR(std::sqrt(square / kTrials), 1, 4 / std::sqrt(2.0 * kTrials));
  const Counts weak = beam(1, 100);
  EXPECT_LT(u, measure_signature(weak, {}).u_rate_dn_per_s);
}

TEST(SignatureExposures, EqualExposuresShareEquallyAndNoneMayMissTheCore) {
  const Counts a = beam(1, 7), b = beam(1, 8);
  const MergedSignature m = merge_signature(std::vector<ScaledCounts>{{&a, 1, 0}, {&b, 1, 1}}, {});
  EXPECT_NEAR(m.share[0], 0.5, 1e-3);
  EXPECT_NEAR(m.level_dn, merge_signature(std::vector<ScaledCounts>{{&a, 1, 0}}, {}).level_dn, 50);
  const Counts c = beam(10, 9), d = beam(12, 10);
  EXPECT_THROW(merge_signature(std::vector<ScaledCounts>{{&c, 1, 0}, {&d, 10.0 / 12, 1}}, {}), Error);
}

}  // namespace
}  // namespace scatmap
