// The kernels as compiled here, for the baseline without fused multiply-adds, against the clone that the program picks
// on this machine: within the bounds that are stated for all instruction sets. And maps by one and two threads, byte
// for byte. Does not prove AVX2 on a machine that has AVX-512.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "scatmap/angles/angle_kernel.h"
#include "scatmap/angles/angle_method.h"
#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/tile_kernel.h"
#include "tests/support/random_instrument.h"

namespace scatmap {
namespace {

constexpr std::size_t kColumns = 1001;

struct Angles {
  std::vector<double> theta = std::vector<double>(kColumns), phi = theta;
};

double direction_difference(const Angles& a, const Angles& b) {
  double worst = 0;
  for (std::size_t i = 0; i < kColumns; ++i) {
    const double across = std::sin(a.theta[i]) * std::remainder(a.phi[i] - b.phi[i], 2 * std::numbers::pi);
    const double difference = std::hypot(a.theta[i] - b.theta[i], across);
    if (!(difference <= worst)) worst = difference;
  }
  return worst;
}

kernel::FarSegment<double> line(double theta, double phi, double step) {
  return {-500,
          -std::sin(theta) * std::cos(phi),
          -std::sin(theta) * std::sin(phi),
          std::cos(theta),
          0,
          0,
          0,
          step * 0.6,
          step * -0.7,
          step * 0.2};
}

TEST(AngleKernel, FarInTheBaselineIsWithinTheBound) {
  for (const double theta : {0.0, 1e-9, 0.3, 1.0, 1.5}) {
    for (const double phi : {0.0, 0.7, 3.14159, 5.5}) {
      for (const double step : {1e-9, 1e-5, 4e-4}) {
        Angles here, picked;
        kernel::far_angles(line(theta, phi, step), kColumns, here.theta.data(), here.phi.data());
        kernel::run_far(line(theta, phi, step), kColumns, picked.theta.data(), picked.phi.data());
        EXPECT_LE(direction_difference(here, picked), 2 * kVectorMaxError_rad) << theta << " " << phi << " " << step;
      }
    }
  }
}

TEST(AngleKernel, NearInTheBaselineIsWithinTheBound) {
  kernel::NearSegment<double> s{-500,  3.0,           1e-17,         0.8,  -2e-17, 1e-4,
                                -2e-5, std::sin(0.8), std::cos(0.8), 3e-5, 1e-9,   -2e-5};
  Angles here, picked;
  kernel::near_angles(s, kColumns, here.theta.data(), here.phi.data());
  kernel::run_near(s, kColumns, picked.theta.data(), picked.phi.data());
  EXPECT_LE(direction_difference(here, picked), 2 * kVectorMaxError_rad);
}

TEST(AngleKernel, TileRowsInTheBaselineAreWithinFloatArithmetic) {
  kernel::RowPolynomial<float> p{
      -128, 0.5f, 3.0f, {1e-9f, 3e-5f, 1e-10f, 2e-15f, 1e-20f}, {2e-9f, -4e-5f, 3e-10f, 1e-15f, 0}};
  std::vector<float> t(257), f(257), theta(257), phi(257);
  kernel::tile_row<4>(p, 257, t.data(), f.data());
  kernel::run_tile_row(4, p, 257, theta.data(), phi.data());
  for (std::size_t i = 0; i < 257; ++i) {
    EXPECT_LE(std::abs(t[i] - theta[i]), 6e-8f);  // one unit of the last place of 0.5
    EXPECT_LE(std::abs(f[i] - phi[i]), 2.4e-7f);
  }
}

TEST(AngleKernel, DoubleTileRowsInTheBaselineAreWithinTheBound) {
  kernel::RowPolynomial<double> p{-128, 0.5, 3.0, {1e-9, 3e-5, 1e-10, 2e-15}, {2e-9, -4e-5, 3e-10, 1e-15}};
  for (std::size_t k = 4; k <= 10; ++k) p.theta_part[k] = p.phi_part[k] = std::pow(3e-5, static_cast<double>(k));
  Angles here, picked;
  kernel::tile_row<10>(p, 257, here.theta.data(), here.phi.data());
  kernel::run_tile_row(10, p, 257, picked.theta.data(), picked.phi.data());
  EXPECT_LE(direction_difference(here, picked), 2 * kVectorMaxError_rad);
  EXPECT_GT(here.theta[256], 0.5);
}

template <class T>
std::vector<char> bytes_with_threads(const SampleView& view, const AngleChoice& choice, int rows, int columns,
                                     std::size_t threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  AngleMapOf<T> map{0, {rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}};
  write_angle_map(view, choice, map);
  std::vector<char> out;
  const auto add = [&](const auto& grid) {
    const char* begin = reinterpret_cast<const char*>(grid.data());
    out.insert(out.end(), begin, begin + grid.size() * sizeof(*grid.data()));
  };
  add(map.theta_s_rad);
  add(map.phi_s_rad);
  add(map.solid_angle_sr);
  add(map.mask);
  return out;
}

TEST(AngleKernel, TheSameBytesWithOneAndTwoThreads) {
  std::mt19937_64 rng(3);
  for (int i = 0; i < 4; ++i) {
    const auto bench = test::random_bench(rng, 1);
    const SampleView view = sample_view(bench.instrument, bench.pose());
    const int rows = bench.truth.rows, columns = bench.truth.columns;
    for (const AngleMethod method : angle_methods()) {
      const AngleChoice choice = with_method(method, view, rows, columns, 0.01);
      const auto bytes = fills_single(method) ? bytes_with_threads<float> : bytes_with_threads<double>;
      EXPECT_TRUE(bytes(view, choice, rows, columns, 1) == bytes(view, choice, rows, columns, 2)) << to_string(method);
    }
  }
}

}  // namespace
}  // namespace scatmap
