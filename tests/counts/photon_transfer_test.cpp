// Sensor characterisation against made sensors of which every number is known: values, and standard uncertainties that
// are the spread over seeds. Does not prove that a real camera follows the linear model of EMVA 1288.
#include "scatmap/counts/photon_transfer.h"

#include <gtest/gtest.h>

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
    current.push_back((last.dark_current_e_per_s->value - kDark_e_per_s) / last.dark_current_e_per_s->u);
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
