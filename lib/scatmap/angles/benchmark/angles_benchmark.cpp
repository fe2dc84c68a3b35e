// Times of the angle room's kernels per pixel, at four frame sizes and by one and two threads. Buffers are used again:
// what is measured is the work, not the first touch of memory.
#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "scatmap/angles/angle_method.h"
#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/direction_pixels.h"
#include "scatmap/angles/opencv_lens.h"
#include "scatmap/base/parallel.h"
#include "scatmap/base/units.h"

namespace scatmap {
namespace {

SampleView paper_view(int columns, int rows) {
  Instrument in;
  in.columns = columns;
  in.rows = rows;
  in.geometry.distance = 0.325;
  in.geometry.pixel_column = 3296 * 5.5e-6 / columns;
  in.geometry.pixel_row = 2472 * 5.5e-6 / rows;
  return sample_view(in, {20 * kRadPerDeg, 40 * kRadPerDeg});
}

struct Frame {
  explicit Frame(const benchmark::State& state)
      : columns(static_cast<int>(state.range(0))),
        rows(static_cast<int>(state.range(1))),
        threads(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(state.range(2))),
        view(paper_view(columns, rows)) {}
  int columns, rows;
  tbb::global_control threads;
  SampleView view;

  void report(benchmark::State& state) const {
    const auto pixels = static_cast<std::int64_t>(columns) * rows;
    state.SetItemsProcessed(state.iterations() * pixels);
    state.counters["ns_per_pixel"] =
        benchmark::Counter(static_cast<double>(pixels) * 1e-9,
                           benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  }
};

template <class T>
void angles(benchmark::State& state, AngleMethod method) {
  const Frame f(state);
  AngleMapOf<T> map{0, {f.rows, f.columns}, {f.rows, f.columns}, {}, {}};
  const auto fill = [&] { write_angle_map(f.view, with_method(method, f.view, f.rows, f.columns, 0.01), map); };
  fill();  // the first touch of fresh memory costs more than all the rest
  for (auto _ : state) fill();
  f.report(state);
}

// As a program's first call finds them: fresh maps each time.
template <class T>
void fresh_angles(benchmark::State& state, AngleMethod method) {
  const Frame f(state);
  for (auto _ : state) {
    AngleMapOf<T> map{0, {f.rows, f.columns}, {f.rows, f.columns}, {}, {}};
    write_angle_map(f.view, with_method(method, f.view, f.rows, f.columns, 0.01), map);
    benchmark::DoNotOptimize(map.theta_s_rad.data());
  }
  f.report(state);
}

void narrow(benchmark::State& state, AngleMethod method) { angles<float>(state, method); }
void wide(benchmark::State& state, AngleMethod method) { angles<double>(state, method); }
void fresh_narrow(benchmark::State& state, AngleMethod method) { fresh_angles<float>(state, method); }
void fresh_wide(benchmark::State& state, AngleMethod method) { fresh_angles<double>(state, method); }

void projected_solid_angle(benchmark::State& state) {
  const Frame f(state);
  Grid<double> omega(f.rows, f.columns, 0.0);  // given values: the pages are touched here, not in the loop
  for (auto _ : state) {
    for_each_row(f.rows, [&](int r) {
      AngleRow<double> out;
      out.projected_solid_angle_sr = omega.row(r);
      angle_row(f.view, r, {0, f.columns}, out);
    });
  }
  f.report(state);
}

void inverse(benchmark::State& state) {
  const Frame f(state);
  Grid<double> x(f.rows, f.columns), y(f.rows, f.columns), z(f.rows, f.columns), column(f.rows, f.columns, 0.0),
      row(f.rows, f.columns, 0.0);
  for (int r = 0; r < f.rows; ++r) {
    for (int c = 0; c < f.columns; ++c) {
      const Vector3<double> ray = f.view.pixel(c, r).normalized();
      x(r, c) = ray.x();
      y(r, c) = ray.y();
      z(r, c) = ray.z();
    }
  }
  for (auto _ : state) {
    for_each_row(f.rows, [&](int r) {
      pixels_of_directions(f.view, f.rows, f.columns, {x.row(r), y.row(r), z.row(r)}, {column.row(r), row.row(r)});
    });
  }
  f.report(state);
}

void lens(benchmark::State& state) {
  const Frame f(state);
  const double scale = f.columns / 1024.0;
  const OpencvLens lens{
      1100 * scale, 1090 * scale, 0.5 * f.columns, 0.5 * f.rows, {-0.25, 0.06, 1e-3, -2e-3, 0.01, 0.02, -0.01, 0.004}};
  const Matrix3<double> turn = rotation_y<double>(0.35);
  Grid<double> theta(f.rows, f.columns, 0.0), phi(f.rows, f.columns, 0.0);
  for (auto _ : state) {
    for_each_row(f.rows, [&](int r) {
      AngleRow<double> out;
      out.theta_s_rad = theta.row(r);
      out.phi_s_rad = phi.row(r);
      lens_angle_row(lens, turn, r, {0, f.columns}, out);
    });
  }
  f.report(state);
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"columns", "rows", "threads"})->UseRealTime()->Unit(benchmark::kMillisecond);
  for (const int threads : {1, 2}) {
    b->Args({512, 512, threads})->Args({1024, 1024, threads})->Args({3296, 2472, threads})->Args({8192, 8192, threads});
  }
}

BENCHMARK_CAPTURE(narrow, linear, AngleMethod::kLinear)->Apply(sizes);
BENCHMARK_CAPTURE(narrow, tile, AngleMethod::kTile)->Apply(sizes);
BENCHMARK_CAPTURE(narrow, single, AngleMethod::kSingle)->Apply(sizes);
BENCHMARK_CAPTURE(wide, vector, AngleMethod::kVector)->Apply(sizes);
BENCHMARK_CAPTURE(wide, exact, AngleMethod::kExact)->Apply(sizes);
BENCHMARK_CAPTURE(fresh_narrow, tile, AngleMethod::kTile)->Apply(sizes);
BENCHMARK_CAPTURE(fresh_wide, vector, AngleMethod::kVector)->Apply(sizes);
BENCHMARK(projected_solid_angle)->Apply(sizes);
BENCHMARK(inverse)->Apply(sizes);
BENCHMARK(lens)->Apply(sizes);

}  // namespace
}  // namespace scatmap

BENCHMARK_MAIN();
