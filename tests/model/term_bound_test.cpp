// Interval bounds of the terms: values and Taylor polynomials of the simulator's long double lie inside them, over
// random ranges of pixels. Not proven: that the bounds are tight (a useless bound would pass; frame_model_test.cpp
// checks that culling leaves terms out).
#include "scatmap/model/term_bound.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "accuracy/model_regimes.h"

namespace scatmap {
namespace {

using accuracy::ModelCase;
using Long = long double;

constexpr double kDistance_m = accuracy::kDistance_mm * 1e-3;

struct Scene {
  ModelCase model;
  DirectionPlane plane;
};

double uniform(std::mt19937_64& r, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(r);
}

// One term on a detector of 5e-5 rad pixels around the specular direction.
Scene random_scene(std::mt19937_64& r, int kind) {
  const double theta = uniform(r, 0.02, 1.4);
  Scene s{accuracy::empty_case({-std::sin(theta), 0, std::cos(theta)}, uniform(r, -90, 90)), {}};
  const double m = std::exp(uniform(r, std::log(2e-4), 0));
  if (kind == 0) accuracy::add_lobe(s.model, 1, m, {uniform(r, 1.1, 4), 0});
  if (kind == 1) accuracy::add_lobe(s.model, 1, m, {uniform(r, 0.1, 4), uniform(r, 0, 4)}, 0.5, uniform(r, 0, 360));
  if (kind >= 2) {
    accuracy::add_stripes(s.model, 300, 800, 10, 325e3 * m, kind == 2 ? StripesForm::kPaper : StripesForm::kGrating);
  }
  const Vector3<double> right(std::cos(theta), 0, -std::sin(theta));
  s.plane.column_step = 5e-5 * right;
  s.plane.row_step = {0, 5e-5, 0};
  s.plane.origin =
      Vector3<double>(std::sin(theta), 0, std::cos(theta)) - 500 * (s.plane.column_step + s.plane.row_step);
  return s;
}

Long truth(const Scene& s, Long column, Long row) {
  const Vector3<Long> ray =
      s.plane.origin.cast<Long>() + column * s.plane.column_step.cast<Long>() + row * s.plane.row_step.cast<Long>();
  return accuracy::truth_at(s.model, ray / ray.norm());
}

// Rounding of the doubles that go into model and truth (degrees against radians) is no part of the bounds.
constexpr Long kRounding = 1e-9L;
// The truth drops factors below 1e-60.
constexpr Long kCut = 1e-50L;

TEST(TermBound, HoldsValues) {
  std::mt19937_64 r(41);
  int tight = 0;
  for (int k = 0; k < 2000; ++k) {
    const Scene s = random_scene(r, k % 4);
    const ModelKernel kernel(s.model.model, s.model.wi, kDistance_m);
    const double column = uniform(r, 0, 1000), row = uniform(r, 0, 1000), size = std::exp(uniform(r, -3, 5));
    const PixelRange range{{column, column + size}, {row, row + size}};
    const Interval bound =
        term_series(kernel.terms()[0], range_directions<0>(s.plane, s.model.wi, range, Along::kColumns)).c[0];
    for (int i = 0; i < 20; ++i) {
      const Long v = truth(s, column + size * (i < 2 ? i : uniform(r, 0, 1)), row + size * uniform(r, 0, 1));
      EXPECT_GE(v, bound.low - kRounding * bound.low - kCut);
      EXPECT_LE(v, bound.high + kRounding * bound.high + kCut);
    }
    tight += bound.high < 2 * bound.low + 1e-12 ? 1 : 0;
  }
  EXPECT_GT(tight, 500);
}

// f(x + d) lies in the Taylor polynomial at x, from bounds at that one point, plus the last coefficient's bound over
// the whole range times d^N.
template <int N>
void expect_taylor(unsigned long seed) {
  std::mt19937_64 r(seed);
  int bounded = 0, small = 0;
  for (int k = 0; k < 1500; ++k) {
    const Scene s = random_scene(r, k % 4);
    const ModelKernel kernel(s.model.model, s.model.wi, kDistance_m);
    const auto& term = kernel.terms()[0];
    const double size = std::exp(uniform(r, -3, 3));
    // Where a Gaussian has not yet fallen far.
    const double column = 500 + uniform(r, -8, 8), row = 500 + uniform(r, -8, 8);
    const PixelRange range{{column, column + size}, {row, row + size}};
    const Along along = k % 8 < 4 ? Along::kColumns : Along::kRows;
    const auto whole = term_series(term, range_directions<N>(s.plane, s.model.wi, range, along));
    const auto point = term_series(term, range_directions<N>(s.plane, s.model.wi, {column, row}, along));
    if (!whole.c[N].bounded()) continue;
    ++bounded;
    const double step = size * uniform(r, 0, 1);
    Interval value = whole.c[N];
    for (std::size_t i = N; i-- > 0;) value = value * Interval(step) + point.c[i];
    const Long v = along == Along::kColumns ? truth(s, Long(column) + step, row) : truth(s, column, Long(row) + step);
    const Long rounding = kRounding * whole.c[0].high + kCut;
    EXPECT_GE(v, value.low - rounding) << k;
    EXPECT_LE(v, value.high + rounding) << k;
    small += value.width() < 1e-3 * whole.c[0].high ? 1 : 0;
  }
  EXPECT_GT(bounded, 1000);
  EXPECT_GT(small, 300);
}

TEST(TermBound, HoldsTaylorPolynomialsOfFourthOrder) { expect_taylor<4>(42); }
TEST(TermBound, HoldsTaylorPolynomialsOfEighthOrder) { expect_taylor<8>(43); }

TEST(Interval, HoldsResultsOfItsMembers) {
  std::mt19937_64 r(44);
  const auto interval = [&] {
    const double a = uniform(r, -3, 3), b = a + std::exp(uniform(r, -40, 1));
    return Interval(a, b);
  };
  const auto member = [&](const Interval& a) { return static_cast<Long>(a.low + (a.high - a.low) * uniform(r, 0, 1)); };
  const auto expect_in = [](Long v, const Interval& a) {
    EXPECT_GE(v, a.low);
    EXPECT_LE(v, a.high);
  };
  constexpr Long kPi = std::numbers::pi_v<Long>;
  for (int i = 0; i < 20000; ++i) {
    const Interval a = interval(), b = interval();
    const Long x = member(a), y = member(b);
    expect_in(x + y, a + b);
    expect_in(x - y, a - b);
    expect_in(x * y, a * b);
    expect_in(x / y, a / b);
    expect_in(x * x, square(a));
    expect_in(std::exp(x), exp(a));
    if (a.low >= 0) expect_in(std::sqrt(x), sqrt(a));
    expect_in(std::cos(kPi * x), cos_pi(a));
    expect_in(std::sin(kPi * x), sin_pi(a));
    expect_in(x == 0 ? 1 : std::sin(kPi * x) / (kPi * x), sinc_pi(a));
  }
}

TEST(Interval, SaysWhatItCannotBound) {
  EXPECT_FALSE((Interval(1) / Interval(-1, 1)).bounded());
  EXPECT_FALSE((Interval(0) * Interval::everything()).bounded());
  EXPECT_FALSE(sqrt(Interval(-2, -1)).bounded());
  EXPECT_EQ(cos_pi(Interval(0, 2)).low, -1);
  EXPECT_EQ(cos_pi(Interval(-0.1, 0.1)).high, 1);
}

}  // namespace
}  // namespace scatmap
