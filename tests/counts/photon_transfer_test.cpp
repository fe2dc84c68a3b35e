// Sensor characterisation against made sensors of which every number is known: values, and standard uncertainties that
// are the spread over seeds; a sensor that the simulator bends comes out straight within the claim. Does not prove that
// a real camera follows the model of EMVA 1288, or that its curve is smooth.
#include "scatmap/counts/photon_transfer.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "data-synthetic/render.h"
#include "scatmap/base/error.h"
#include "tests/counts/made_frames.h"

namespace scatmap {
namespace {

constexpr int kSide = 80;
constexpr double kDark_e_per_s = 30, kDsnu_e = 5, kPrnu = 0.012, kLight_e_per_s = 10000;

struct Made {
  std::vector<double> exposure_s;
  std::vector<std::vector<Frame>> flats, darks;
  std::vector<TransferLevel> levels() const {
    std::vector<TransferLevel> out;
    for (std::size_t i = 0; i < exposure_s.size(); ++i) out.push_back({exposure_s[i], flats[i], darks[i]});
    return out;
  }
};

// Poisson light with a pixel pattern and a slope over the frame; `compress`: relative loss at full scale.
Made made(std::vector<double> exposures, std::uint64_t seed, double compress = 0, int frames = 2) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  Grid<double> response(kSide, kSide), offset(kSide, kSide);
  for (std::size_t i = 0; i < response.size(); ++i) {
    response[i] = (1 + kPrnu * normal(rng)) * (1 + 0.05 * (static_cast<double>(i % kSide) / kSide - 0.5));
    offset[i] = kDsnu_e * normal(rng);
  }
  Made out{std::move(exposures), {}, {}};
  const SensorModel sensor = test::kSensor;
  for (const double t : out.exposure_s) {
    Grid<double> light(kSide, kSide), dark(kSide, kSide);
    for (std::size_t i = 0; i < light.size(); ++i) {
      dark[i] = 50 + offset[i] + kDark_e_per_s * t;  // 50 e of offset keeps the pattern positive
      const double e = kLight_e_per_s * t * response[i];
      light[i] = dark[i] + e * (1 - compress * e / 95000);
    }
    out.flats.push_back(test::made_frames(frames, light, 0, sensor, rng));
    out.darks.push_back(test::made_frames(frames, dark, 0, sensor, rng));
  }
  return out;
}

const std::vector<double> kLadder{0.1, 0.5, 1, 2, 3, 4, 5, 6, 7, 8, 9};

TEST(PhotonTransfer, EveryNumberAndItsSigma) {
  std::vector<double> gain, noise, current, dsnu, prnu;
  PhotonTransfer last;
  constexpr int kSeeds = 40;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Made m = made(kLadder, 100 + seed);
    last = photon_transfer(m.levels(), test::kSensor.saturation_dn);
    gain.push_back((last.gain_dn_per_e.value - 1 / test::kSensor.gain_e_per_dn) / last.gain_dn_per_e.u);
    // The dark pattern's own shot noise (53 e² at the shortest exposure) is temporal noise too.
    noise.push_back(
        (last.dark_noise_e.value - std::sqrt(test::kSensor.read_noise_e * test::kSensor.read_noise_e + 53)) /
        last.dark_noise_e.u);
    current.push_back((last.dark_current_e_per_s.value - kDark_e_per_s) / last.dark_current_e_per_s.u);
    dsnu.push_back((last.dsnu_e.value - kDsnu_e) / last.dsnu_e.u);
    prnu.push_back((last.prnu.value - kPrnu) / last.prnu.u);
  }
  for (const auto* z : {&gain, &noise, &current, &dsnu, &prnu}) {
    const test::Moments m = test::moments(*z);
    EXPECT_NEAR(std::sqrt(m.mean * m.mean + m.sd * m.sd), 1, 4 / std::sqrt(2.0 * kSeeds))
        << (z == &gain      ? "gain"
            : z == &noise   ? "noise"
            : z == &current ? "current"
            : z == &dsnu    ? "dsnu"
                            : "prnu");
  }
  EXPECT_LE(last.gain_dn_per_e.u / last.gain_dn_per_e.value, 0.01);
  EXPECT_LE(last.linearity_error->value, 1e-3);
  EXPECT_NEAR(last.bias_dn.value, 300 + 50 / 1.5, 0.5);
}

TEST(PhotonTransfer, SaturationIsWhereTheVarianceTurns) {
  const Made m = made({0.5, 2, 5, 8, 9, 9.6, 10.5, 12}, 7);
  const PhotonTransfer p = photon_transfer(m.levels(), std::nullopt);
  ASSERT_TRUE(p.saturation_dn.has_value());
  EXPECT_GE(*p.saturation_dn, 60000);
  EXPECT_LE(*p.saturation_dn, 65535);
  EXPECT_FALSE(p.points.back().used);
  EXPECT_NEAR(p.gain_dn_per_e.value * 1.5, 1, 0.02);
}

TEST(PhotonTransfer, CompressionShowsAsLinearityError) {
  const Made m = made(kLadder, 8, 0.02);
  const PhotonTransfer p = photon_transfer(m.levels(), test::kSensor.saturation_dn);
  EXPECT_GT(p.linearity_error->value, 1e-3);
  EXPECT_LT(p.linearity_error->value, 1e-2);
  EXPECT_GE(*p.largest_deviation, p.linearity_error->value);
}

// The simulator's sensor: bent by `percent` at full scale after the photons' Poisson draw, cut by its converter.
Made simulated(double percent, std::uint64_t seed, std::vector<double> exposures, double light_jitter = 0) {
  synth::SensorTruth sensor;
  sensor.gain_e_per_dn = 1.5;
  sensor.read_noise_e = 8;
  sensor.bias_dn = 300;
  sensor.dark_e_per_s = 30;
  sensor.nonlinearity_percent = percent;
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  Made out{std::move(exposures), {}, {}};
  std::uint64_t number = 0;
  const auto frames = [&](double light_e, double t) {
    Grid<double> signal(kSide, kSide);
    for (int r = 0; r < kSide; ++r) {
      for (int c = 0; c < kSide; ++c) signal(r, c) = light_e * (1 + 0.2 * (c / static_cast<double>(kSide) - 0.5));
    }
    std::vector<Frame> list;
    for (int k = 0; k < 2; ++k) {
      const Grid<std::uint16_t> dn = synth::render_frame(signal, sensor, t, {seed, number++});
      Frame f{Grid<float>(kSide, kSide), 1, "simulated", {}};
      for (std::size_t i = 0; i < dn.size(); ++i) f.dn[i] = dn[i];
      list.push_back(std::move(f));
    }
    return list;
  };
  for (const double t : out.exposure_s) {
    out.flats.push_back(frames(kLight_e_per_s * t * (1 + light_jitter * normal(rng)), t));
    out.darks.push_back(frames(0, t));
  }
  return out;
}

// Largest difference of corrected signal per electron between any two levels from 5 % to full scale.
double left_after(const PhotonTransfer& p, double percent) {
  const SensorModel sensor{1.5, 8, 65535, p.bias_dn.value, p.linearity};
  const double full_e = (65535.0 - 300) * 1.5;
  double low = 1e9, high = 0;
  for (double e = 0.05 * full_e; e <= 0.985 * full_e; e += 0.005 * full_e) {
    const double raw = 300 + e * (1 + percent / 100 * e / full_e) / 1.5;
    if (raw > 64500) break;
    const double per_e = (sensor.linearised(raw) - p.bias_dn.value) / e;
    low = std::min(low, per_e);
    high = std::max(high, per_e);
  }
  return high / low - 1;
}

const std::vector<double> kLinearLadder{0.6, 1.2, 2.4, 3.6, 4.8, 6, 7, 8, 9, 11, 13};

TEST(PhotonTransfer, ABentSensorComesOutStraightWithinTheClaim) {
  for (const double percent : {-3.0, -0.8, 0.0, 1.5}) {
    int within = 0;
    double claim = 0, largest = 0;
    constexpr int kSeeds = 20;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const PhotonTransfer p = photon_transfer(simulated(percent, 700 + seed, kLinearLadder).levels(), std::nullopt);
      ASSERT_TRUE(p.nonlinearity_left.has_value());
      within += left_after(p, percent) <= *p.nonlinearity_left ? 1 : 0;
      claim = std::max(claim, *p.nonlinearity_left);
      largest = std::max(largest, left_after(p, percent));
      EXPECT_NEAR(p.gain_dn_per_e.value * 1.5, 1, 4 * p.gain_dn_per_e.u * 1.5) << percent << " seed " << seed;
    }
    std::printf("bent by %+.1f %%: left %.5f at most, claimed %.5f at most, within in %d of %d\n", percent, largest,
                claim, within, kSeeds);
    EXPECT_GE(within, 0.9 * kSeeds) << percent;
    EXPECT_LE(claim, 3e-3) << percent;  // as bent as 3 % before
  }
}

TEST(PhotonTransfer, UnsteadyLightWidensTheClaim) {
  int within = 0;
  double sum = 0;
  constexpr int kSeeds = 20;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const PhotonTransfer p = photon_transfer(simulated(-2, 900 + seed, kLinearLadder, 2e-3).levels(), std::nullopt);
    within += left_after(p, -2) <= *p.nonlinearity_left ? 1 : 0;
    sum += *p.nonlinearity_left;
  }
  EXPECT_GE(within, 0.85 * kSeeds);
  EXPECT_GT(sum / kSeeds, 2e-3);
  EXPECT_LT(sum / kSeeds, 2e-2);
}

TEST(PhotonTransfer, AStraightSensorNeedsNoCoefficients) {
  int none = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    none += photon_transfer(simulated(0, 40 + seed, kLinearLadder).levels(), std::nullopt).linearity.empty() ? 1 : 0;
  EXPECT_GE(none, 18);
}

// The user's word on saturation rules, unless the flats refute it.
TEST(PhotonTransfer, StatedSaturationRules) {
  const auto m = simulated(0, 3, {0.6, 2, 4, 6, 7, 12, 14});
  const PhotonTransfer p = photon_transfer(m.levels(), 65535.0, 50000.0);
  ASSERT_TRUE(p.saturation_dn.has_value());
  EXPECT_EQ(*p.saturation_dn, 50000);
  EXPECT_THROW(photon_transfer(m.levels(), 65535.0, 70000.0), Error);
  EXPECT_NE(*photon_transfer(m.levels(), 50000.0).saturation_dn, 50000);
  EXPECT_THROW(photon_transfer(m.levels(), std::nullopt, 500.0), Error);
}

// A ladder with a wide gap below saturation: the converter's ceiling is known all the same.
TEST(PhotonTransfer, SaturationIsNotNeedlesslyLow) {
  const PhotonTransfer p = photon_transfer(simulated(0, 3, {0.6, 2, 4, 6, 7, 12, 14}).levels(), std::nullopt);
  ASSERT_TRUE(p.saturation_dn.has_value());
  const double noise = std::sqrt(65235 / 1.5);
  EXPECT_NEAR(*p.saturation_dn, 65535 - kCeilingSigmas * noise, 0.1 * kCeilingSigmas * noise);
}

// A stuck column and hits of single frames shifted bias, noise and gain by many of their u.
TEST(PhotonTransfer, DefectsAndHitsChangeNothing) {
  const Made plain = made(kLadder, 21);
  Made spoilt = plain;
  std::mt19937_64 rng(5);
  for (auto* frames : {&spoilt.flats, &spoilt.darks}) {
    for (std::vector<Frame>& level : *frames) {
      for (Frame& f : level) {
        for (int row = 0; row < kSide; ++row) f.dn(row, 7) = 65535;
        for (int hit = 0; hit < 3; ++hit) f.dn[rng() % f.dn.size()] += 300;  // too few to count as defects
      }
    }
  }
  const PhotonTransfer a = photon_transfer(plain.levels(), 65535.0), b = photon_transfer(spoilt.levels(), 65535.0);
  EXPECT_EQ(a.left_out_pixels, 0u);
  EXPECT_GE(b.left_out_pixels, static_cast<std::size_t>(kSide));
  EXPECT_LE(b.left_out_pixels, static_cast<std::size_t>(kSide) + 12);  // hits in the darks that tell
  const auto same = [](const Estimate& x, const Estimate& y) { return std::abs(x.value - y.value) <= 2 * x.u; };
  EXPECT_TRUE(same(a.bias_dn, b.bias_dn)) << a.bias_dn.value << " " << b.bias_dn.value << " " << b.bias_dn.u;
  EXPECT_TRUE(same(a.dark_noise_e, b.dark_noise_e)) << a.dark_noise_e.value << " " << b.dark_noise_e.value;
  EXPECT_TRUE(same(a.gain_dn_per_e, b.gain_dn_per_e)) << a.gain_dn_per_e.value << " " << b.gain_dn_per_e.value;
  EXPECT_EQ(a.nonlinearity_left.has_value(), b.nonlinearity_left.has_value());
}

TEST(PhotonTransfer, ExchangedExposuresAreRefused) {
  Made m = made({1, 2, 4, 6}, 22);
  std::swap(m.flats[1], m.flats[2]);
  try {
    photon_transfer(m.levels(), 65535.0);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("flats: of 4 s are darker than those of 2 s"), std::string::npos) << e.what();
  }
}

// Two exposure times give the bias, not the shortest dark.
TEST(PhotonTransfer, TwoExposuresTellTheBias) {
  const Made m = made({2, 8}, 23);
  const PhotonTransfer p = photon_transfer(m.levels(), 65535.0);
  const double truth = test::kSensor.bias_dn + 50 / test::kSensor.gain_e_per_dn;
  const double u_pattern = kDsnu_e / kSide / test::kSensor.gain_e_per_dn;  // of its mean over the frame
  EXPECT_NEAR(p.bias_dn.value, truth, 4 * std::hypot(p.bias_dn.u, u_pattern));
  EXPECT_NEAR(p.dark_current_e_per_s.value, kDark_e_per_s, 4 * p.dark_current_e_per_s.u);
}

TEST(PhotonTransfer, RefusesWhatItCannotUse) {
  Made m = made({1, 2}, 9);
  std::vector<TransferLevel> levels = m.levels();
  EXPECT_THROW(photon_transfer(std::span(levels).first(1), std::nullopt), Error);
  levels[0].flats = levels[0].flats.first(1);
  EXPECT_THROW(photon_transfer(levels, std::nullopt), Error);
  levels = m.levels();
  levels[1].darks = {};
  EXPECT_THROW(photon_transfer(levels, std::nullopt), Error);
  levels = m.levels();
  for (TransferLevel& l : levels) l.flats = l.darks;  // no light at all
  levels[1].flats = m.darks[0];
  levels[1].darks = m.darks[1];
  EXPECT_THROW(photon_transfer(levels, 65535.0), Error);
}

}  // namespace
}  // namespace scatmap
