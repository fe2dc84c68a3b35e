// Which method is chosen for a tolerance, and that the small pieces under the bounds hold: Taylor remainders and frame
// extents against samples of the frame. Does not prove the methods' errors: tests/accuracy does.
#include "scatmap/angles/angle_method.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/frame_extent.h"
#include "scatmap/angles/taylor_bound.h"
#include "scatmap/base/stream_copy.h"
#include "tests/support/random_instrument.h"

namespace scatmap {
namespace {

SampleView bench_view(double theta_deg, int columns, int rows, double pitch_m) {
  Instrument in;
  in.columns = columns;
  in.rows = rows;
  in.geometry.distance = 0.325;
  in.geometry.pixel_column = in.geometry.pixel_row = pitch_m;
  return sample_view(in, {theta_deg * kRadPerDeg, 2 * theta_deg * kRadPerDeg});
}

SampleView paper_view(double theta_deg) { return bench_view(theta_deg, 1024, 1024, 13e-6); }

TEST(AngleMethod, TheFastestThatMeetsTheTolerance) {
  const SampleView view = paper_view(20);
  EXPECT_EQ(choose_angle_method(view, 1024, 1024, 1e4).method, AngleMethod::kLinear);
  EXPECT_EQ(choose_angle_method(view, 1024, 1024, 0.01).method, AngleMethod::kTile);
  EXPECT_EQ(choose_angle_method(view, 1024, 1024, 1e-4).method, AngleMethod::kVector);
  EXPECT_EQ(choose_angle_method(view, 1024, 1024, 0).method, AngleMethod::kVector);
  for (const double tolerance : {1e4, 1.0, 0.01, 0.003, 1e-4}) {
    const AngleChoice choice = choose_angle_method(view, 1024, 1024, tolerance);
    EXPECT_LE(choice.bound_px, tolerance * (1 + 1e-9));
    EXPECT_GT(choice.bound_px, 0);
  }
}

TEST(AngleMethod, SingleIsWithinThreeThousandthsOfAPixelOnThePapersBench) {
  EXPECT_LE(with_method(AngleMethod::kSingle, paper_view(20), 1024, 1024, 0).bound_px, 0.003);
  const SampleView fine = bench_view(20, 3296, 2472, 5.5e-6);
  EXPECT_LE(with_method(AngleMethod::kSingle, fine, 3296, 2472, 0).bound_px, 0.003);
  EXPECT_EQ(choose_angle_method(fine, 3296, 2472, 0.003).method, AngleMethod::kTile);
}

TEST(AngleMethod, NamesAndBack) {
  for (const AngleMethod method : angle_methods()) EXPECT_EQ(angle_method(to_string(method)), method);
  EXPECT_FALSE(angle_method("fast").has_value());
}

TEST(AngleMethod, NoLinearMapAboutThePole) {
  const SampleView view = paper_view(0.1);
  EXPECT_FALSE(std::isfinite(with_method(AngleMethod::kLinear, view, 1024, 1024, 1).bound_rad));
}

TEST(AngleMethod, FrameExtentHoldsEveryPixel) {
  std::mt19937_64 rng(12);
  for (int i = 0; i < 200; ++i) {
    const auto bench = test::random_bench(rng, 1 + i % 4);
    const int rows = bench.truth.rows, columns = bench.truth.columns;
    SampleView view;
    try {
      view = sample_view(bench.instrument, bench.pose());
    } catch (const std::exception&) {
      continue;
    }
    const FrameExtent e = frame_extent(view, rows, columns);
    for (int k = 0; k < 100; ++k) {
      const int c = static_cast<int>(rng() % static_cast<unsigned>(columns)),
                r = static_cast<int>(rng() % static_cast<unsigned>(rows));
      const PixelAngles a = pixel_angles(view, c, r);
      const Vector3<double> p = view.pixel(c, r);
      EXPECT_GE(p.norm(), e.nearest_m * (1 - 1e-14));
      if (a.mask != 0) continue;
      EXPECT_GE(a.theta_s_rad, e.theta_min_rad - 1e-14);
      EXPECT_LE(a.theta_s_rad, e.theta_max_rad + 1e-14);
      EXPECT_LE(a.phi_s_rad, e.phi_max_rad + 1e-14);
      EXPECT_GE(angle_between<double>(p, view.pixel(c + 0.7, r - 0.7)), e.pixel_step_rad * 0.95);
      EXPECT_GE(angle_between<double>(p, view.pixel(c, r + 1)), e.pixel_step_rad * 0.999);
    }
  }
}

// theta and phi of points on a line against their Taylor polynomials of degree 0, the plainest there is to write here.
TEST(AngleMethod, TaylorRemainderOfDegreeZeroBoundsTheChange) {
  std::mt19937_64 rng(13);
  const auto within = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng); };
  int finite = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3<double> p(within(-1, 1), within(-1, 1), within(0.01, 1));
    const Vector3<double> u =
        Vector3<double>(within(-1, 1), within(-1, 1), within(-1, 1)) * std::pow(10, within(-4, -0.5));
    const double rho = std::hypot(p.x(), p.y()), r = p.norm();
    const double bound = taylor_remainder_rad({rho, rho, r, r, std::hypot(u.x(), u.y()), u.norm()}, 1, 0);
    if (!std::isfinite(bound)) continue;
    ++finite;
    const Vector3<double> q = p + u;
    const double d_phi = std::remainder(azimuth_from_minus_x(q) - azimuth_from_minus_x(p), 2 * std::numbers::pi);
    const double change = std::hypot(polar_angle(q) - polar_angle(p), std::sin(polar_angle(q)) * d_phi);
    EXPECT_LE(change, bound);
  }
  EXPECT_GT(finite, 1000);
}

// Tiles in double, asked for remainders that rounding does not hide: every degree from 5 to 10 comes into play.
// @return of all errors the largest, as a share of the remainder allowed and the rounding
double worst_tile_share(const SampleView& view, int rows, int columns, const TilePlan& plan) {
  AngleMap map{0, {rows, columns}, {rows, columns}, {}, {}};
  write_tile_map(view, plan, map);
  const double allowed = plan.truncation_rad + vector_bound_rad(frame_extent(view, rows, columns));
  double worst = 0;
  for (int r = 0; r < rows; r += 3) {
    for (int c = 0; c < columns; c += 5) {
      long double p[3];
      for (int k = 0; k < 3; ++k) p[k] = view.origin[k] + (long double)c * view.column_step[k] + r * view.row_step[k];
      const long double rho = std::hypot(p[0], p[1]);
      const long double d_theta = map.theta_s_rad(r, c) - std::atan2(rho, p[2]);
      const long double d_phi =
          std::remainder(map.phi_s_rad(r, c) - std::atan2(p[1], p[0]) - std::numbers::pi_v<long double>,
                         2 * std::numbers::pi_v<long double>);
      const auto share = static_cast<double>(std::hypot(d_theta, d_phi * rho / std::hypot(rho, p[2])) /
                                             static_cast<long double>(allowed));
      if (!(share <= worst)) worst = share;
    }
  }
  return worst;
}

TEST(AngleMethod, TilesInDoubleKeepTheirRemainder) {
  double largest = 0;
  for (const double theta_deg : {2.0, 20.0, 60.0, 80.0}) {
    const SampleView view = paper_view(theta_deg);
    for (const double truncation_rad : {1e-8, 1e-10, 1e-12, 1e-14, kVectorTruncation_rad}) {
      for (int width = 64; width <= 1024; width *= 4) {
        const TilePlan plan{width, truncation_rad, 1};
        const double share = worst_tile_share(view, 200, 1024, plan);
        EXPECT_LE(share, 1) << theta_deg << " " << truncation_rad << " " << width;
        if (truncation_rad >= 1e-12) largest = std::max(largest, share);
      }
    }
    if (theta_deg >= 20) {
      EXPECT_EQ(plan_tiles<double>(view, 1024, 1024, kVectorTruncation_rad).polynomial_share, 1) << theta_deg;
    }
  }
  EXPECT_GT(largest, 1e-3);  // the bound is not so wide that it says nothing
}

// Maps of kStreamedBytes and more are written past the caches, at odd places in their lines.
TEST(AngleMethod, LargeMapsAreTheSameAsTheirRows) {
  constexpr int kRows = 2051, kColumns = 2053;
  const SampleView view = bench_view(20, kColumns, kRows, 5.5e-6);
  const AngleChoice choice = with_method(AngleMethod::kVector, view, kRows, kColumns, 0);
  AngleMap map{0, {kRows, kColumns}, {kRows, kColumns}, {}, {}};
  EXPECT_GE(2 * sizeof(double) * map.theta_s_rad.size(), kStreamedBytes);
  std::fill(map.theta_s_rad.begin(), map.theta_s_rad.end(), std::nan(""));
  std::fill(map.phi_s_rad.begin(), map.phi_s_rad.end(), std::nan(""));
  write_angle_map(view, choice, map);
  std::size_t wrong = 0;
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; c += r % 32 == 0 ? 1 : 61) {
      const PixelAngles a = pixel_angles(view, c, r);
      const double off = std::hypot(map.theta_s_rad(r, c) - a.theta_s_rad,
                                    std::sin(a.theta_s_rad) * (map.phi_s_rad(r, c) - a.phi_s_rad));
      wrong += !(off <= choice.bound_rad + kExactMaxError_rad);
    }
  }
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace scatmap
