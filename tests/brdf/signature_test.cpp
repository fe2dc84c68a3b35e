// The beam signature: whole spot, background removed, honest σ; what is no signature is refused.
#include "scatmap/brdf/signature.h"

#include <gtest/gtest.h>

#include "scatmap/base/error.h"
#include "tests/counts/made_frames.h"

namespace scatmap {
namespace {

using test::kSensor;

Grid<double> gaussian(int side, double column, double row, double sigma, double total, double background) {
  Grid<double> out(side, side, background);
  const auto part = [&](double x, double centre) {
    return 0.5 *
           (std::erf((x + 0.5 - centre) / sigma / std::sqrt(2)) - std::erf((x - 0.5 - centre) / sigma / std::sqrt(2)));
  };
  for (int r = 0; r < side; ++r) {
    for (int c = 0; c < side; ++c) out(r, c) += total * part(c, column) * part(r, row);
  }
  return out;
}

Counts counts_of(const Grid<double>& e, std::uint64_t seed, int hot = 0) {
  std::mt19937_64 rng(seed);
  auto darks = test::made_frames(5, Grid<double>(e.rows(), e.columns(), 0.0), 4, kSensor, rng);
  auto frames = test::made_frames(2, e, 4, kSensor, rng);
  for (int k = 0; k < hot; ++k) {
    const int r = static_cast<int>(rng() % static_cast<unsigned>(e.rows())),
              c = static_cast<int>(rng() % static_cast<unsigned>(e.columns()));
    for (auto* list : {&darks, &frames}) {
      for (Frame& f : *list) f.dn(r, c) = 65535;
    }
  }
  return reduce(frames, combine_darks(darks, kSensor), kSensor, {}, 1.0);
}

TEST(Signature, SumAndItsSigma) {
  constexpr double kTotal = 3e6;
  std::vector<double> error, claimed;
  for (int t = 0; t < 150; ++t) {
    const Signature s =
        measure_signature(counts_of(gaussian(120, 61.3, 57.8, 5, kTotal, 40), 100 + static_cast<std::uint64_t>(t)), {});
    error.push_back(s.rate_dn_per_s * 1.5 / kTotal - 1);
    claimed.push_back(s.u_rate_dn_per_s * 1.5 / kTotal);
    EXPECT_NEAR(s.column, 61.3, 0.05);
    EXPECT_NEAR(s.row, 57.8, 0.05);
  }
  const test::Moments m = test::moments(error);
  EXPECT_NEAR(test::moments(claimed).mean / m.sd, 1, 4 / std::sqrt(2 * m.n));
  EXPECT_LE(std::abs(m.mean), 4 * m.sd / std::sqrt(m.n) + 1e-5);
}

TEST(Signature, HotPixelsAreReplacedNotRefused) {
  int replaced = 0;
  for (int t = 0; t < 20; ++t) {
    const Signature s =
        measure_signature(counts_of(gaussian(120, 60, 60, 5, 3e6, 0), 300 + static_cast<std::uint64_t>(t), 60), {});
    EXPECT_NEAR(s.rate_dn_per_s * 1.5 / 3e6, 1, std::max(4e-3, 5 * s.u_rate_dn_per_s / s.rate_dn_per_s));
    replaced += s.replaced_pixels;
  }
  EXPECT_GT(replaced, 10);
}

TEST(Signature, RefusesSaturationDarknessAndCutBeams) {
  EXPECT_THROW(measure_signature(counts_of(gaussian(100, 50, 50, 5, 3e8, 0), 1), {}), Error);
  EXPECT_THROW(measure_signature(counts_of(Grid<double>(100, 100, 0.0), 2), {}), Error);
  EXPECT_THROW(measure_signature(counts_of(Grid<double>(100, 100, 500.0), 3), {}), Error);
  EXPECT_THROW(measure_signature(counts_of(gaussian(100, 4, 50, 5, 3e6, 0), 4), {}), Error);
}

// Nothing but noise has a brightest spot too, and sometimes a positive sum.
TEST(Signature, NoiseIsNoBeam) {
  for (std::uint64_t seed = 10; seed < 20; ++seed) {
    try {
      measure_signature(counts_of(Grid<double>(100, 100, 0.0), seed), {});
      ADD_FAILURE() << "accepted, seed " << seed;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("does not stand out of the noise"), std::string::npos) << e.what();
    }
  }
}

TEST(Signature, GivenRadiusIsUsed) {
  const Signature s = measure_signature(counts_of(gaussian(120, 60, 60, 5, 3e6, 0), 5), 20.0);
  EXPECT_EQ(s.radius_px, 20);
  EXPECT_NEAR(s.rate_dn_per_s * 1.5 / 3e6, 1 - std::exp(-0.5 * 16), 3e-3);
}

TEST(Signature, RingOfASecondFainterSpotIsNotBackground) {
  Grid<double> e = gaussian(160, 70, 80, 5, 3e6, 20);
  const Grid<double> ghost = gaussian(160, 70 + 36, 80, 2, 2e4, 0);
  for (std::size_t i = 0; i < e.size(); ++i) e[i] += ghost[i];
  const Signature s = measure_signature(counts_of(e, 6), {});
  EXPECT_NEAR(s.rate_dn_per_s * 1.5 / 3e6, 1, 5e-3);
}

}  // namespace
}  // namespace scatmap
