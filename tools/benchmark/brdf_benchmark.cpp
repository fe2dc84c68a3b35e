// Time of counts → BRDF in memory: the fused pass with its parts switched off one by one, and the exact chain.
// Items are pixels; planes are filled again, so no fresh page is touched.
#include <benchmark/benchmark.h>

#include <map>

#include "scatmap/brdf/merge.h"
#include "scatmap/brdf/pose_uncertainty.h"
#include "tools/chart/brdf_scene.h"
#include "tools/chart/scene.h"
#include "tools/chart/timing.h"

namespace scatmap::tools {
namespace {

// Of the size last asked for: 8192² takes a while and 2 GB.
const BrdfScene& scene_of(int columns, int rows, int frames) {
  static BrdfScene scene;
  static std::array<int, 3> made{};
  if (made != std::array{columns, rows, frames}) {
    const ChartSettings s = chart_settings({}, {});
    scene = {};
    scene = brdf_scene(resized(s.instrument, columns, rows), s.pose, frames);
    made = {columns, rows, frames};
  }
  return scene;
}

struct Size {
  int columns, rows;
};
constexpr std::array kSizes{Size{512, 512}, Size{1024, 1024}, Size{3296, 2472}, Size{8192, 8192}};

void count_pixels(benchmark::State& state, const BrdfScene& s) {
  const auto pixels = static_cast<double>(s.dark.mask.size());
  state.counters["ns/px"] =
      benchmark::Counter(pixels * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

// Arguments: size, threads, frames, with u_pose.
void Fused(benchmark::State& state) {
  const Size size = kSizes[static_cast<std::size_t>(state.range(0))];
  const BrdfScene& s = scene_of(size.columns, size.rows, static_cast<int>(state.range(2)));
  const SampleView view = sample_view(s.instrument, s.pose);
  const PoseTiles pose(view, calibration_changes(s.instrument, s.pose), size.rows, size.columns);
  FusedPlanes<float> planes;
  with_threads(static_cast<int>(state.range(1)), [&] {
    const auto fill = [&] {
      fused_map(s.fused_frames(), {view, nullptr, state.range(3) != 0 ? &pose : nullptr}, {}, planes);
    };
    fill();  // the first touch of fresh memory
    for (auto _ : state) {
      fill();
      benchmark::DoNotOptimize(planes.brdf_per_sr.data());
    }
  });
  count_pixels(state, s);
}
BENCHMARK(Fused)
    ->ArgNames({"size", "threads", "frames", "pose"})
    ->ArgsProduct({{0, 1, 2, 3}, {1, 2}, {1}, {0, 1}})
    ->Args({2, 1, 4, 1})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// The parts of the exact chain, one thread each time.
void ExactReduce(benchmark::State& state) {
  const Size size = kSizes[static_cast<std::size_t>(state.range(0))];
  const BrdfScene& s = scene_of(size.columns, size.rows, static_cast<int>(state.range(1)));
  with_threads(1, [&] {
    for (auto _ : state) benchmark::DoNotOptimize(reduce(s.frames, s.dark, s.sensor, s.response, s.exposure_s));
  });
  count_pixels(state, s);
}
BENCHMARK(ExactReduce)->Args({2, 1})->Args({2, 4})->UseRealTime()->Unit(benchmark::kMillisecond);

void ExactMerge(benchmark::State& state) {
  const BrdfScene& s = scene_of(kSizes[2].columns, kSizes[2].rows, 1);
  const Counts counts = reduce(s.frames, s.dark, s.sensor, s.response, s.exposure_s);
  with_threads(1, [&] {
    const std::vector<ScaledCounts> scaled{{&counts, s.factor, 0}};
    for (auto _ : state) benchmark::DoNotOptimize(merge(scaled));
  });
  count_pixels(state, s);
}
BENCHMARK(ExactMerge)->UseRealTime()->Unit(benchmark::kMillisecond);

void PoseUncertainty(benchmark::State& state) {
  const BrdfScene& s = scene_of(kSizes[2].columns, kSizes[2].rows, 1);
  const Grid<double> f(kSizes[2].rows, kSizes[2].columns, 3.0);
  with_threads(1, [&] {
    for (auto _ : state) benchmark::DoNotOptimize(pose_uncertainty(s.instrument, s.pose, f));
  });
  count_pixels(state, s);
}
BENCHMARK(PoseUncertainty)->UseRealTime()->Unit(benchmark::kMillisecond);

void CombineDarks(benchmark::State& state) {
  const BrdfScene& s = scene_of(kSizes[2].columns, kSizes[2].rows, 4);
  with_threads(1, [&] {
    for (auto _ : state) benchmark::DoNotOptimize(combine_darks(s.frames, s.sensor));
  });
  count_pixels(state, s);
}
BENCHMARK(CombineDarks)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace scatmap::tools

BENCHMARK_MAIN();
