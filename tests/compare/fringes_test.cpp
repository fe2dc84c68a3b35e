// Fringe counts, spacings and heights on combs of known period. Not proven here: combs whose period changes along them.
#include "scatmap/compare/fringes.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "compare/synthetic_map.h"
#include "scatmap/compare/band.h"

namespace scatmap {
namespace {

using synthetic::Comb;
using synthetic::Lobe;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <class F>
Profile profile_of(int half, const F& f, double noise, unsigned seed) {
  Profile p;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (int s = -half; s <= half; ++s) {
    p.position.push_back({0, static_cast<double>(s)});
    p.offset_px.push_back(s);
    p.angle_deg.push_back(0.002 * s);
    p.value_per_sr.push_back(f(s) + noise * normal(random));
    p.u_random_per_sr.push_back(noise);
  }
  return p;
}

TEST(Fringes, EveryFringeIsCountedAlsoWithNoise) {
  constexpr double kPeriod = 19.3;
  const auto comb = [](double s) {
    const double c = std::cos(std::numbers::pi * s / kPeriod);
    return 300 * std::exp(-std::abs(s) / 1400) * c * c;
  };
  constexpr int kTrials = 40;
  double first = 0, last = 0;
  for (unsigned seed = 0; seed < kTrials; ++seed) {
    const Profile p = profile_of(510, comb, 15, seed);  // 5 % of the highest, 7 % at the ends
    const auto found = find_fringes(p, 0);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->orders_after, 26) << seed;  // 26 × 19.3 = 501.8 of 510
    EXPECT_EQ(found->orders_before, 26) << seed;
    ASSERT_EQ(found->maxima.size(), 52u) << seed;
    EXPECT_LE(std::abs(found->spacing_px - kPeriod), 4 * found->spacing_sigma_px);
    EXPECT_LE(found->spacing_sigma_px, 0.01);
    EXPECT_LE(std::abs(found->spacing_deg - 0.002 * kPeriod), 4 * found->spacing_sigma_deg);
    first += found->first_height_per_sr / (300 * std::exp(-19.3 / 1400)) / kTrials;
    last += found->last_height_per_sr / (300 * std::exp(-501.8 / 1400)) / kTrials;
  }
  // One height has a standard error of 2 to 3 %, their mean over the trials 0.4 %. A cos² summit is sharper than
  // exp(quadratic) far from it, which raises the fit by half a percent.
  EXPECT_LE(std::abs(first - 1), 0.015) << first << " " << last;
  EXPECT_LE(std::abs(last - 1), 0.02);
}

TEST(Fringes, NoiseAndSlopesHaveNone) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    EXPECT_TRUE(find_maxima(profile_of(
                                1000, [](double) { return 0.0; }, 1, seed))
                    .empty());
    EXPECT_TRUE(find_maxima(profile_of(
                                1000, [](double s) { return 50 + 0.04 * s; }, 3, seed))
                    .empty());
  }
}

TEST(Fringes, CutFringesAtTheEndsAreNotCounted) {
  const auto comb = [](double s) { return 100 * std::pow(std::cos(std::numbers::pi * s / 20), 2); };
  const auto ends_on_flank = find_fringes(profile_of(95, comb, 1, 3), 0);  // maxima at 20 … 80; 95 rises towards 100
  ASSERT_TRUE(ends_on_flank);
  EXPECT_EQ(ends_on_flank->orders_after, 4);
  EXPECT_EQ(ends_on_flank->orders_before, 4);
}

TEST(Fringes, OrdersUnderTheLobeAreCountedAndKeptOutOfHeights) {
  const auto pattern = [](double s) {
    const double c = std::cos(std::numbers::pi * s / 19);
    return 300 * c * c + 1.1e4 * std::exp(-s * s / (9.6 * 9.6));
  };
  const auto found = find_fringes(profile_of(500, pattern, 5, 4), 3 * 9.6);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->orders_after, 26);
  EXPECT_EQ(found->orders_before, 26);
  EXPECT_LE(std::abs(found->first_height_per_sr / 300 - 1), 0.03);
  EXPECT_LE(std::abs(found->spacing_px - 19), 0.01);
}

TEST(Fringes, MaskedFringesKeepTheirOrder) {
  const auto comb = [](double s) { return 100 * std::pow(std::cos(std::numbers::pi * s / 20), 2); };
  Profile p = profile_of(210, comb, 1, 5);
  for (int s = 95; s <= 125; ++s) p.value_per_sr[static_cast<std::size_t>(s + 210)] = kNaN;  // orders 5 and 6
  const auto found = find_fringes(p, 0);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->orders_after, 10);
  EXPECT_LE(std::abs(found->spacing_px - 20), 0.02);
}

TEST(Fringes, TooFewAreNoComb) {
  const auto three = [](double s) { return 100 * std::exp(-s * s / 25) + 50 * std::exp(-(s - 30) * (s - 30) / 25); };
  EXPECT_FALSE(find_fringes(profile_of(100, three, 1, 6), 0));
  Profile empty;
  EXPECT_FALSE(find_fringes(empty, 0));
}

// The whole way: map, peaks, band, ridge, fringes. Periods in pixels become degrees through the geometry.
TEST(Fringes, OfAMapAlongItsRidge) {
  const Lobe centre{400, 380, 1.1e4, 9.6}, offset{520, 500, 4.4e4, 9.6};
  const Comb comb{400, 380, 75, 19.3, 300, 6, 1e-4};
  const BrdfMap map = synthetic::noisy(
      800, 766, [&](double c, double r) { return 0.5 + centre(c, r) + offset(c, r) + comb(c, r); }, 0.5, 2, 7);
  const std::vector<Peak> peaks = find_peaks(map);
  const auto band = find_band(map, peaks);
  ASSERT_TRUE(band);
  const auto found = find_fringes(ridge_profile(map, *band), 3 * peaks[band->peak].radius_px);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->orders_after, 20);   // (765 − 380 − bend)/sin 75° = 394 = 20.4 periods
  EXPECT_EQ(found->orders_before, 20);  // (380 + bend)/sin 75° = 397 = 20.6 periods
  EXPECT_LE(std::abs(found->spacing_px / 19.3 - 1), 2e-3);
  EXPECT_LE(std::abs(found->spacing_deg / (19.3 * 13.5e-6 / 0.325 * kDegPerRad) - 1), 3e-3);
  EXPECT_LE(std::abs(found->first_height_per_sr / 300 - 1), 0.06);
  EXPECT_LE(std::abs(found->last_height_per_sr / 300 - 1), 0.1);
}

}  // namespace
}  // namespace scatmap
