// Time per pixel of every method of the model on the paper's scene, at four sizes of the same sensor, on one and two
// threads, in memory that is reused. The counter per_pixel is what to look at.
#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <cmath>

#include "scatmap/base/grid.h"
#include "scatmap/base/units.h"
#include "scatmap/model/frame_model.h"

namespace scatmap {
namespace {

constexpr double kThetaI_rad = 20 * kRadPerDeg, kDistance_m = 0.325;

Model paper_model() {
  return {632.8e-9,
          Polarization::kUnpolarized,
          0,
          {MicrofacetTerm{0.7, 2e-4, 1.4, 0.5 * kRadPerDeg, 45 * kRadPerDeg}, MicrofacetTerm{0.015, 2e-4, 3.6, 0, 0},
           StripesTerm{300, 8e-4, 1e-5, 4e-5, StripesForm::kPaper}, LambertianTerm{0.05}}};
}

// The paper's scene without anything that can be left out: lobes as wide as the frame.
Model wide_model() {
  Model model = paper_model();
  for (Term& term : model.terms) {
    if (auto* lobe = std::get_if<MicrofacetTerm>(&term)) lobe->m = 0.05;
    if (auto* stripes = std::get_if<StripesTerm>(&term)) stripes->c_m = 1e-2;
  }
  return model;
}

DirectionPlane sensor(int rows, int columns) {
  const double c = std::cos(kThetaI_rad), s = std::sin(kThetaI_rad);
  DirectionPlane plane;
  plane.column_step = 3296 * 5.5e-6 / columns * Vector3<double>(c, 0, -s);
  plane.row_step = {0, 2472 * 5.5e-6 / rows, 0};
  plane.origin = kDistance_m * Vector3<double>(s, 0, c) - (columns - 1) / 2.0 * plane.column_step -
                 (rows - 1) / 2.0 * plane.row_step;
  return plane;
}

void measure(benchmark::State& state, const Model& model, const FrameModelOptions& options) {
  const auto columns = static_cast<int>(state.range(0)), rows = static_cast<int>(state.range(1));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(state.range(2)));
  Grid<double> values(rows, columns, 0.0);
  const FrameModel frame(model, {-std::sin(kThetaI_rad), 0, std::cos(kThetaI_rad)}, kDistance_m, sensor(rows, columns),
                         rows, columns, options);
  for (auto _ : state) {
    frame.fill({values.data(), values.size()});
    benchmark::DoNotOptimize(values.data());
    benchmark::ClobberMemory();
  }
  state.counters["per_pixel"] = benchmark::Counter(
      static_cast<double>(values.size()), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"columns", "rows", "threads"})->Unit(benchmark::kMillisecond)->UseRealTime();
  for (const int threads : {1, 2}) {
    b->Args({512, 512, threads})->Args({1024, 1024, threads})->Args({3296, 2472, threads})->Args({8192, 8192, threads});
  }
}

BENCHMARK_CAPTURE(measure, exact, paper_model(), {ModelMethod::kExact})->Apply(sizes);
BENCHMARK_CAPTURE(measure, vector, paper_model(), {ModelMethod::kVector})->Apply(sizes);
BENCHMARK_CAPTURE(measure, single, paper_model(), {ModelMethod::kSingle})->Apply(sizes);
BENCHMARK_CAPTURE(measure, culled_1e9, paper_model(), {ModelMethod::kCulled, 1e-9})->Apply(sizes);
BENCHMARK_CAPTURE(measure, culled_1e6, paper_model(), {ModelMethod::kCulled, 1e-6})->Apply(sizes);
BENCHMARK_CAPTURE(measure, average_1e6, paper_model(), {ModelMethod::kCulled, 1e-6, true})->Apply(sizes);
BENCHMARK_CAPTURE(measure, wide_vector, wide_model(), {ModelMethod::kVector})->Apply(sizes);
BENCHMARK_CAPTURE(measure, wide_single, wide_model(), {ModelMethod::kSingle})->Apply(sizes);
BENCHMARK_CAPTURE(measure, wide_culled_1e6, wide_model(), {ModelMethod::kCulled, 1e-6})->Apply(sizes);

}  // namespace
}  // namespace scatmap

BENCHMARK_MAIN();
