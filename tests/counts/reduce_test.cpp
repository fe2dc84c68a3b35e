// Net counts: unbiased, with a σ that does not follow the fluctuation it describes; saturation, outliers, flat,
// linearity.
#include "scatmap/counts/reduce.h"

#include <gtest/gtest.h>

#include "scatmap/base/error.h"
#include "scatmap/counts/expected_signal.h"
#include "tests/counts/made_frames.h"

namespace scatmap {
namespace {

using test::kSensor;

struct Made {
  std::vector<Frame> frames;
  MasterDark dark;
};

Made make(const Grid<double>& expected_e, int frames, std::uint64_t seed, const SensorModel& sensor = kSensor) {
  std::mt19937_64 rng(seed);
  const auto darks = test::made_frames(7, Grid<double>(expected_e.rows(), expected_e.columns(), 0.0), 4, sensor, rng);
  return {test::made_frames(frames, expected_e, 4, sensor, rng), combine_darks(darks, sensor)};
}

struct Pulls {
  test::Moments pull;
  double ratio_minus_1_over_error;
};

// σ at the locally expected signal, as the product uses it; σ from the very count, as many reducers do.
Pulls pulls(const Counts& c, double expected_rate, bool from_own_count) {
  Grid<float> floor(c.mask.rows(), c.mask.columns());
  for (std::size_t i = 0; i < floor.size(); ++i) floor[i] = c.frame_floor[i] + c.dark_floor[i];
  const Grid<double> expected =
      from_own_count ? c.rate_dn_per_s : expected_signal(c.rate_dn_per_s, floor, c.shot, c.mask);
  std::vector<double> z;
  double sum = 0, variance = 0, weighted = 0, weight = 0;
  for (std::size_t i = 0; i < floor.size(); ++i) {
    const double v = floor[i] + std::max(0.0, expected[i]) * c.shot[i], d = c.rate_dn_per_s[i] - expected_rate;
    z.push_back(d / std::sqrt(v));
    sum += d;
    variance += v;
    weighted += d / v;
    weight += 1 / v;
  }
  return {test::moments(z), weighted / weight / (std::sqrt(1 / weight))};
}

TEST(Reduce, SigmaHoldsFromTheFloorToBrightAndAWeightedMeanIsUnbiased) {
  constexpr int kSide = 220, kFrames = 2;
  for (const double e : {0.0, 1.0, 5.0, 30.0, 200.0, 5000.0}) {
    const Made m = make(Grid<double>(kSide, kSide, e), kFrames, 100 + static_cast<std::uint64_t>(e));
    const Counts c = reduce(m.frames, m.dark, kSensor, {}, 2.0);
    const Pulls p = pulls(c, e / 1.5 / 2.0, false);
    const double rms = std::sqrt(p.pull.mean * p.pull.mean + p.pull.sd * p.pull.sd);
    EXPECT_NEAR(rms, 1, 0.02) << e;
    // The weighted mean over 48,400 pixels is unbiased within four of its own standard errors plus 1 % of one pixel's
    // σ.
    EXPECT_LE(std::abs(p.ratio_minus_1_over_error), 4 + 0.01 * kSide) << e;
  }
}

// What is avoided: with σ from the very count, the weighted mean of dim pixels is biased by many standard errors.
TEST(Reduce, SigmaFromTheOwnCountWouldBias) {
  const SensorModel quiet{1.5, 2, 65535, 300, {}};
  const Made m = make(Grid<double>(220, 220, 5.0), 1, 5, quiet);
  const Counts c = reduce(m.frames, m.dark, quiet, {}, 1.0);
  EXPECT_LE(std::abs(pulls(c, 5 / 1.5, false).ratio_minus_1_over_error), 4 + 0.01 * 220);
  EXPECT_GE(std::abs(pulls(c, 5 / 1.5, true).ratio_minus_1_over_error), 40);
}

TEST(Reduce, AMasterDarkSharedByFramesIsOneError) {
  // Σ over frames of (S_k − D)/K: the frames' noise falls with K, the dark's does not.
  std::vector<double> means;
  double claimed = 0;
  for (int trial = 0; trial < 400; ++trial) {
    std::mt19937_64 rng(static_cast<std::uint64_t>(1000 + trial));
    const Grid<double> zero(8, 8, 0.0);
    const auto darks = test::made_frames(3, zero, 4, kSensor, rng);
    const Counts c =
        reduce(test::made_frames(32, zero, 4, kSensor, rng), combine_darks(darks, kSensor), kSensor, {}, 1.0);
    for (std::size_t i = 0; i < c.rate_dn_per_s.size(); ++i) {
      means.push_back(c.rate_dn_per_s[i]);
      claimed += c.frame_floor[i] + c.dark_floor[i];
    }
  }
  const test::Moments m = test::moments(means);
  EXPECT_NEAR(m.sd / std::sqrt(claimed / m.n), 1, 0.02);
  EXPECT_NEAR(m.sd * m.sd / ((64 + 4) / 2.25 * (1.0 / 32 + 1.0 / 3)), 1, 0.05);
}

TEST(Reduce, SaturationIsDecidedOnRawCountsAndItsNeighboursAreMasked) {
  Grid<double> e(20, 20, 100.0);
  Made m = make(e, 3, 6);
  m.frames[1].dn(10, 10) = 65535;
  const Counts c = reduce(m.frames, m.dark, kSensor, {}, 1.0);
  EXPECT_EQ(c.mask(10, 10) & kSaturated, kSaturated);
  EXPECT_EQ(c.mask(9, 11), kBloom);
  EXPECT_EQ(c.mask(12, 10), 0);
  EXPECT_EQ(c.saturated_pixels, 1u);
}

TEST(Reduce, ACosmicHitIsRejectedAmongThreeFramesAndMaskedAmongTwo) {
  for (const int frames : {3, 2}) {
    Made m = make(Grid<double>(20, 20, 100.0), frames, 7);
    m.frames[0].dn(4, 4) += 3000;
    const Counts c = reduce(m.frames, m.dark, kSensor, {}, 1.0);
    EXPECT_EQ(c.mask(4, 4), frames == 3 ? 0 : kCosmic);
    if (frames == 3) {
      EXPECT_NEAR(c.rate_dn_per_s(4, 4), 100 / 1.5, 6 * std::sqrt((64 + 104) / 2.25 / 2));
    }
  }
}

TEST(Reduce, NegativeNetCountsStayWithAFiniteSigma) {
  const Made m = make(Grid<double>(50, 50, 0.0), 1, 8);
  const Counts c = reduce(m.frames, m.dark, kSensor, {}, 1.0);
  int negative = 0;
  for (std::size_t i = 0; i < c.rate_dn_per_s.size(); ++i) {
    negative += c.rate_dn_per_s[i] < 0;
    EXPECT_GT(c.frame_floor[i], 0);
  }
  EXPECT_NEAR(negative / 2500.0, 0.5, 0.05);
}

TEST(Reduce, FlatAndBadPixels) {
  Grid<double> e(10, 10, 30000.0);
  for (int r = 0; r < 10; ++r) e(r, 3) = 15000;
  const Made m = make(e, 4, 9);
  Frame flat{Grid<float>(10, 10, 2.f), 1, "flat", {}};
  for (int r = 0; r < 10; ++r) flat.dn(r, 3) = 1;
  flat.dn(5, 5) = 0;
  PixelResponse response{Grid<Mask>(10, 10, Mask{0}), normalised_flat(flat)};
  response.bad(1, 2) = kBad;
  const Counts c = reduce(m.frames, m.dark, kSensor, response, 1.0);
  EXPECT_NEAR(c.rate_dn_per_s(2, 3) / c.rate_dn_per_s(2, 4), 1, 0.03);
  EXPECT_NEAR(std::sqrt(c.shot(2, 3) / c.shot(2, 4)), std::sqrt(2), 1e-3);
  EXPECT_EQ(c.mask(5, 5), kFlatInvalid);
  EXPECT_EQ(c.mask(1, 2), kBad);
}

TEST(Reduce, LinearityPolynomialUndoesACompressionOfFramesAndDarksAlike) {
  // A sensor that reads x (1 − 1e-6 x): the inverse to third order as correction.
  SensorModel s = kSensor;
  s.linearity = {1e-6, 2e-12, 5e-18};
  Made m = make(Grid<double>(40, 40, 60000.0), 4, 10);
  for (Frame& f : m.frames) {
    for (float& v : f.dn.floats()) v = static_cast<float>(300 + (v - 300) * (1 - 1e-6 * (v - 300)));
  }
  const Counts raw = reduce(m.frames, m.dark, kSensor, {}, 1.0), corrected = reduce(m.frames, m.dark, s, {}, 1.0);
  const double truth = 60000 / 1.5;
  EXPECT_GT(std::abs(test::moments(raw.rate_dn_per_s).mean / truth - 1), 0.03);
  EXPECT_LE(std::abs(test::moments(corrected.rate_dn_per_s).mean / truth - 1), 5e-4);
}

TEST(Reduce, ContradictionsAreRefused) {
  Made m = make(Grid<double>(10, 10, 10.0), 2, 11);
  m.frames[1].header.exposure_s = 2.0;
  EXPECT_THROW(reduce(m.frames, m.dark, kSensor, {}, 1.0), Error);
  m.frames[1].header.exposure_s = 1.0;
  EXPECT_NO_THROW(reduce(m.frames, m.dark, kSensor, {}, 1.0));
  m.frames[1].dn = Grid<float>(10, 9, 0.f);
  EXPECT_THROW(reduce(m.frames, m.dark, kSensor, {}, 1.0), Error);
  EXPECT_THROW(reduce({}, m.dark, kSensor, {}, 1.0), Error);
}

TEST(ExpectedSignal, FollowsSteepFeaturesAndSmoothsNoise) {
  constexpr int kSide = 60;
  Grid<double> value(kSide, kSide, 0.0);
  std::mt19937_64 rng(12);
  std::normal_distribution<double> noise(0, 1);
  for (int r = 0; r < kSide; ++r) {
    for (int c = 0; c < kSide; ++c)
      value(r, c) = (c >= 30 ? 1000.0 * std::exp(-0.5 * (c - 45) * (c - 45) / 4.0) : 0) + noise(rng);
  }
  const Grid<double> e = expected_signal(value, Grid<float>(kSide, kSide, 1.f), Grid<float>(kSide, kSide, 0.f),
                                         Grid<Mask>(kSide, kSide, Mask{0}));
  double flat = 0;
  for (int r = 5; r < 55; ++r) {
    for (int c = 5; c < 25; ++c) flat += e(r, c) * e(r, c) / 1000.0;
    EXPECT_NEAR(e(r, 45), value(r, 45), 0.02 * value(r, 45));
  }
  EXPECT_LE(std::sqrt(flat), 0.45);  // the pixel's own noise has mostly gone
}

TEST(ExpectedSignal, MaskedPixelsDoNotSpread) {
  Grid<double> value(9, 9, 1.0);
  Grid<Mask> mask(9, 9, Mask{0});
  value(4, 4) = 1e9;
  mask(4, 4) = kHot;
  const Grid<double> e = expected_signal(value, Grid<float>(9, 9, 1.f), Grid<float>(9, 9, 0.f), mask);
  for (const double v : e) EXPECT_NEAR(v, 1, 1e-12);
}

}  // namespace
}  // namespace scatmap
