// Time of finding spots in a frame and of a centroid by itself, by method.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "calib/spots.h"
#include "calib/spots_ml.h"
#include "calib/spots_moments.h"

namespace scatmap::calib {
namespace {

// One spot of 1e5 electrons, 2 px wide, in the middle, with read noise of 8 electrons.
SpotImage image_of(int columns, int rows) {
  SpotImage image{Grid<double>(rows, columns), Grid<double>(rows, columns), Grid<Mask>(rows, columns, 0), 0};
  std::mt19937_64 rng(4);
  std::normal_distribution<double> normal;
  const GaussianSpot spot = gaussian_spot(columns / 2 + 0.3, rows / 2 - 0.2, 1e5, 4 * Eigen::Matrix2d::Identity());
  const PixelGaussian light(spot);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const double e = std::hypot(c - columns / 2, r - rows / 2) < 30 ? light.at(c, r).value_e : 0;
      image.net_e(r, c) = e + std::sqrt(64 + e) * normal(rng);
      image.floor_e2(r, c) = 64;
    }
  }
  return image;
}

void Find(benchmark::State& state, SpotMethod method) {
  const SpotImage image = image_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  for (auto _ : state) benchmark::DoNotOptimize(find_spots(image, method));
  state.SetItemsProcessed(state.iterations() * state.range(0) * state.range(1));
}
void FindByLikelihood(benchmark::State& state) { Find(state, SpotMethod::kMaximumLikelihood); }
void FindByMoments(benchmark::State& state) { Find(state, SpotMethod::kMoments); }
BENCHMARK(FindByLikelihood)->Args({512, 512})->Args({1024, 1024})->Args({3296, 2472})->Unit(benchmark::kMillisecond);
BENCHMARK(FindByMoments)->Args({512, 512})->Args({1024, 1024})->Args({3296, 2472})->Unit(benchmark::kMillisecond);

void LikelihoodFit(benchmark::State& state) {
  const SpotImage original = image_of(64, 64);
  const GaussianSpot start = gaussian_spot(32, 32, 9e4, 5 * Eigen::Matrix2d::Identity());
  for (auto _ : state) {
    SpotImage image = original;
    benchmark::DoNotOptimize(fit_spots(image, {start}));
  }
}
BENCHMARK(LikelihoodFit)->Unit(benchmark::kMicrosecond);

void Moments(benchmark::State& state) {
  SpotImage image = image_of(64, 64);
  const SpotFit fit = fit_spots(image, {gaussian_spot(32, 32, 9e4, 5 * Eigen::Matrix2d::Identity())});
  for (auto _ : state) benchmark::DoNotOptimize(windowed_centroid(image, fit, 0));
}
BENCHMARK(Moments)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace scatmap::calib

BENCHMARK_MAIN();
