// Time of the scale's statistics: every method at the paper's 59.3 %, and the Monte Carlo of 1.2e7 trials.
#include <benchmark/benchmark.h>

#include "scatmap/base/units.h"
#include "scatmap/brdf/scale_statistics.h"

namespace scatmap {
namespace {

ScaleBudget paper_case() {
  ScaleBudget b;
  for (const double od : {3.0, 0.3, 4.0, 1.0, 0.6, 0.3, 0.1694})
    b.causes.push_back({"filter", Distribution::kRectangular, 0.05 * od, kLn10, true, 0});
  return b;
}

ScaleBudget with_laser_and_times() {
  ScaleBudget b = paper_case();
  b.causes.push_back({"laser drift", Distribution::kRectangular, 0.005, 1, false, 0});
  b.causes.push_back({"exposure times", Distribution::kNormal, 0.001, 1, false, 0});
  return b;
}

template <class Method>
void closed_form(benchmark::State& state, Method method) {
  const ScaleBudget b = with_laser_and_times();
  for (auto _ : state) benchmark::DoNotOptimize(method(b, 0.04));
}

void monte_carlo_of(benchmark::State& state, const ScaleBudget& budget, double relative_normal) {
  const auto trials = static_cast<std::size_t>(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(monte_carlo(budget, relative_normal, trials));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

void adaptive(benchmark::State& state) {
  const ScaleBudget b = with_laser_and_times();
  const double tolerance = numerical_tolerance(first_order(b).sd, static_cast<int>(state.range(0))) / 5;
  for (auto _ : state) benchmark::DoNotOptimize(adaptive_monte_carlo(b, 0.04, tolerance));
}

BENCHMARK_CAPTURE(closed_form, exact_moments, exact_moments);
BENCHMARK_CAPTURE(closed_form, first_order, first_order);
BENCHMARK_CAPTURE(closed_form, second_order, second_order);
BENCHMARK_CAPTURE(closed_form, lognormal, lognormal);
BENCHMARK_CAPTURE(monte_carlo_of, filters, paper_case(), 0)
    ->Arg(10'000)
    ->Arg(1'000'000)
    ->Arg(12'000'000)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(monte_carlo_of, filters_laser_times_noise, with_laser_and_times(), 0.04)
    ->Arg(10'000)
    ->Arg(1'000'000)
    ->Arg(12'000'000)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(adaptive)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace scatmap

BENCHMARK_MAIN();
