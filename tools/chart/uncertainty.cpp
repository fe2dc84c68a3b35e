#include "tools/chart/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "scatmap/base/units.h"
#include "scatmap/brdf/scale_statistics.h"
#include "tools/chart/error_sample.h"
#include "tools/chart/factor_distribution.h"
#include "tools/chart/timing.h"

namespace scatmap::tools {
namespace {

struct Case {
  const char* job;
  const char* title;
  ScaleBudget budget;
  double relative_normal = 0;
};

ScaleBudget filters(std::initializer_list<double> ods) {
  ScaleBudget b;
  for (const double od : ods)
    b.causes.push_back(
        {"filter", Distribution::kRectangular, 0.05 * od, b.causes.size() % 2 == 0 ? kLn10 : -kLn10, true, 0});
  return b;
}

std::vector<Case> cases() {
  ScaleBudget small = filters({0.3});
  small.causes.push_back({"laser drift", Distribution::kRectangular, 0.005, 1, false, 0});
  small.causes.push_back({"exposure times", Distribution::kNormal, 0.002, 1, false, 0});
  return {{"uncertainty_4", "One filter of OD 0.3 and counting noise: 4 % standard uncertainty", small, 0.0342},
          {"uncertainty_14", "The paper's four weak filters: 14 % worst case", filters({1, 0.6, 0.3, 0.1694}), 0},
          {"uncertainty_59", "The paper's stacks, all filters different: 59.3 % worst case",
           filters({3, 4, 0.3, 1, 0.6, 0.3, 0.1694}), 0}};
}

constexpr int kSeeds = 25;

// Over several seeds where the method draws numbers.
template <class Method>
ChartRow row(const Case& c, const ChartSettings& s, const char* name, int threads, bool random, Method&& method) {
  ChartRow out;
  out.method = name;
  out.size = std::to_string(c.budget.causes.size()) + " causes";
  out.threads = threads;
  std::uint64_t seed = 0;
  out.time = with_threads(threads, [&] {
    // Fast methods in batches: a clock takes tens of ns.
    const std::size_t batch = random ? 1 : 1000;
    return time_per_item(batch, s.seconds_per_method, [&] {
      for (std::size_t i = 0; i < batch; ++i) {
        const FactorInterval f = method(seed++);
        keep(&f);
      }
    });
  });
  ErrorSample errors;
  for (int k = 0; k < (random ? kSeeds : 1); ++k)
    errors.add(
        100 * (probability_within(c.budget, c.relative_normal, method(1000 + static_cast<std::uint64_t>(k))) - 0.95), k,
        0);
  out.largest_error = errors.largest();
  out.p99_error = errors.percentile(random ? 50 : 99);
  if (random) out.note = "largest of 25 seeds; in place of the 99th percentile the median";
  return out;
}

// What a script would do: draw, sort, read off.
FactorInterval naive(const Case& c, std::size_t trials, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> within(-1, 1);
  std::normal_distribution<double> normal;
  std::vector<double> factor(trials);
  for (double& f : factor) {
    double ln = 0;
    for (const ScaleCause& cause : c.budget.causes)
      ln += cause.sensitivity * cause.half_width *
            (cause.distribution == Distribution::kNormal ? normal(rng) : within(rng));
    f = std::exp(ln) * (1 + c.relative_normal * normal(rng));
  }
  std::sort(factor.begin(), factor.end());
  const auto at = [&](double p) { return factor[static_cast<std::size_t>(p * static_cast<double>(trials))]; };
  return {at(0.025), at(0.975)};
}

FactorInterval from_moments(const Case& c) {
  const FactorMoments m = exact_moments(c.budget, c.relative_normal);
  constexpr double kNormal95 = 1.959963984540054;
  return {m.mean - kNormal95 * m.sd, m.mean + kNormal95 * m.sd};
}

Chart chart_of(const Case& c, const ChartSettings& s) {
  Chart chart{c.job,
              c.title,
              "evaluation",
              "error of the 95 % coverage",
              "%",
              "distribution of the sum of rectangulars in closed form, normal causes integrated",
              {},
              {},
              {}};
  const double r = c.relative_normal;
  const ScaleBudget& b = c.budget;
  const auto add = [&](const char* name, bool random, auto&& method) {
    chart.rows.push_back(row(c, s, name, 1, random, method));
  };
  add("first order", false, [&](std::uint64_t) { return first_order(b, r).symmetric; });
  add("second order", false, [&](std::uint64_t) { return second_order(b, r).symmetric; });
  add("exact moments", false, [&](std::uint64_t) { return from_moments(c); });
  add("lognormal", false, [&](std::uint64_t) { return lognormal(b, r).symmetric; });
  add("Monte Carlo 1e4", true, [&](std::uint64_t seed) { return monte_carlo(b, r, 10'000, seed).symmetric; });
  add("Monte Carlo 1e6", true, [&](std::uint64_t seed) { return monte_carlo(b, r, 1'000'000, seed).symmetric; });
  for (const int digits : {1, 2}) {
    const double tolerance = numerical_tolerance(first_order(b, r).sd, digits) / 5;
    add(digits == 1 ? "adaptive, 1 digit" : "adaptive, 2 digits", true,
        [&](std::uint64_t seed) { return adaptive_monte_carlo(b, r, tolerance, seed).factor.symmetric; });
  }
  for (const auto& [name, trials] : {std::pair{"draw and sort 1e4", 10'000}, {"draw and sort 1e6", 1'000'000}}) {
    const auto count = static_cast<std::size_t>(trials);  // clang 14 takes no structured binding into a lambda
    add(name, true, [&, count](std::uint64_t seed) { return naive(c, count, seed); });
    chart.rows.back().rival = true;
  }
  chart.error_lines.push_back(
      {"JCGM 101 asks of 1e6 trials: 2 standard deviations", 200 * std::sqrt(0.95 * 0.05 / 1e6)});
  return chart;
}

}  // namespace

std::vector<Chart> chart_uncertainty(const ChartSettings& settings) {
  std::vector<Chart> out;
  for (const Case& c : cases()) out.push_back(chart_of(c, settings));
  return out;
}

}  // namespace scatmap::tools
