#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include <nlohmann/json.hpp>

#include "scatmap/base/error.h"
#include "scatmap/brdf/map_uncertainty.h"
#include "scatmap/brdf/scale_statistics.h"
#include "scatmap/report/map_fits.h"
#include "tools/output_options.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

struct Options {
  std::string map;
  std::vector<int> pixel, region, other;
  bool whole_map = false;
  double target_percent = 0;
  int digits = 1;
  bool json = false;
};

Region region_of(const std::vector<int>& numbers) {
  if (numbers.size() == 2) return {numbers[0], numbers[1], numbers[0], numbers[1]};
  const Region r{numbers[0], numbers[1], numbers[2], numbers[3]};
  if (r.last_column < r.first_column || r.last_row < r.first_row) {
    std::string text;
    for (const int n : numbers) text += (text.empty() ? "" : ",") + std::to_string(n);
    throw Error({"region", "has its corners swapped", text, "first COLUMN,ROW, then last COLUMN,ROW"});
  }
  return r;
}

// One line of a budget; contributions are relative to the value.
struct Row {
  std::string cause, kind, distribution;
  double value = 0, sensitivity = 0, contribution = 0, share = 0;
};

// Share of a cause in the variance: with correlation, its own and half of what it shares with the others.
double variance_share(const ScaleBudget& b, std::size_t k) {
  double sum = 0;
  for (std::size_t j = 0; j < b.causes.size(); ++j) {
    sum += b.correlation_of(k, j) * std::copysign(b.causes[k].standard(), b.causes[k].sensitivity) *
           std::copysign(b.causes[j].standard(), b.causes[j].sensitivity);
  }
  return sum;
}

// `factors` is the map's scale, followed by the structured causes that multiply.
std::vector<Row> budget(const SumUncertainty& u, const ScaleBudget& factors, std::size_t scale_causes) {
  const double size = std::abs(u.value), total2 = std::pow(u.total() / size, 2);
  std::vector<Row> out;
  const auto add = [&](const std::string& cause, const char* kind, double relative) {
    out.push_back({cause, kind, "normal", relative, 1, relative, relative * relative / total2});
  };
  add("counting, read and dark noise", "random", u.random / size);
  const auto directions =
      std::count_if(u.structured.begin(), u.structured.end(), [](const CauseAmount& c) { return c.is_pose; });
  const double additive = u.relative_additive(), random = u.random / size;
  if (directions > 0)
    add("pose (" + std::to_string(directions) + " directions)", "structured",
        std::sqrt(std::max(0.0, additive * additive - random * random)));
  for (const bool structured : {true, false}) {
    for (std::size_t k = 0; k < factors.causes.size(); ++k) {
      if ((k >= scale_causes) != structured) continue;
      const ScaleCause& c = factors.causes[k];
      out.push_back({c.name, structured ? "structured" : "scale", to_string(c.distribution), c.half_width,
                     c.sensitivity, c.standard(), variance_share(factors, k) / total2});
    }
  }
  return out;
}

nlohmann::json interval_json(const FactorInterval& i) {
  return {{"factors", {i.low, i.high}}, {"db", {decibel(i.low), decibel(i.high)}}};
}

nlohmann::json statistics_json(const FactorStatistics& s) {
  return {{"mean", s.mean},
          {"sd", s.sd},
          {"symmetric_95", interval_json(s.symmetric)},
          {"shortest_95", interval_json(s.shortest)}};
}

// Everything said about one pixel or region.
struct Answer {
  SumUncertainty u;
  ScaleBudget factors;
  std::vector<Row> rows;
  FirstOrderVerdict verdict;
  FactorMoments exact;
};

Answer answer_for(const MapUncertainty& uncertainty, const BrdfMap& map, const PixelSum& sum, int digits) {
  Answer a{uncertainty.of(sum), {}, {}, {}, {}};
  if (a.u.value == 0)
    throw Error({"the value", "is 0: nothing is relative to it", {}, "a pixel or region with a BRDF"});
  a.factors = factor_budget(a.u, map.scale);
  a.rows = budget(a.u, a.factors, map.scale.causes.size());
  a.verdict = check_first_order(a.factors, a.u.relative_additive(), digits);
  a.exact = exact_moments(a.factors, a.u.relative_additive());
  return a;
}

nlohmann::json answer_json(const Answer& a) {
  const ScaleBudget& scale = a.factors;
  nlohmann::json out{{"value", a.u.value},
                     {"u_random", a.u.random},
                     {"u_structured", a.u.structured_total()},
                     {"u_without_scale", a.u.without_scale()},
                     {"u_scale_relative", a.u.scale_relative},
                     {"u", a.u.total()},
                     {"expanded_k2", 2 * a.u.total()}};
  for (const Row& r : a.rows) {
    out["budget"].push_back({{"cause", r.cause},
                             {"kind", r.kind},
                             {"distribution", r.distribution},
                             {"value", r.value},
                             {"sensitivity", r.sensitivity},
                             {"contribution", r.contribution},
                             {"share", r.share}});
  }
  out["filters"] = {{"worst_case", scale.filters_worst_case()},
                    {"standard", scale.filters_standard()},
                    {"linear_bound", scale.filters_linear_bound()}};
  out["exact"] = {{"mean", a.exact.mean}, {"sd", a.exact.sd}};
  out["first_order"] = statistics_json(first_order(scale, a.u.relative_additive()));
  out["second_order"] = statistics_json(second_order(scale, a.u.relative_additive()));
  out["lognormal"] = statistics_json(lognormal(scale, a.u.relative_additive()));
  out["monte_carlo"] = statistics_json(a.verdict.monte_carlo.factor);
  out["monte_carlo"].update({{"trials", a.verdict.monte_carlo.trials}, {"converged", a.verdict.monte_carlo.converged}});
  out["clause_8"] = {{"d_low", a.verdict.d_low},
                     {"d_high", a.verdict.d_high},
                     {"delta", a.verdict.delta},
                     {"first_order_valid", a.verdict.valid}};
  return out;
}

void print_interval(const FactorInterval& i, const char* name) {
  std::printf("  %-24s %8.4f to %-8.4f ", name, i.low, i.high);
  if (i.low > 0 && i.high > 0) {
    std::printf("(%+.3f to %+.3f dB)\n", decibel(i.low), decibel(i.high));
  } else {
    std::printf("(reaches 0 or below: no dB)\n");
  }
}

void print_answer(const Answer& a, const char* unit) {
  const ScaleBudget& scale = a.factors;
  const double size = std::abs(a.u.value), r = a.u.relative_additive();
  std::printf("value %.6g%s, standard uncertainty %.3g (%.2f %%): %.2f %% without scale, %.2f %% scale\n", a.u.value,
              unit, a.u.total(), 100 * a.u.total() / size, 100 * a.u.relative_without_scale(),
              100 * a.u.scale_relative);
  std::printf("expanded, k = 2: %.3g (%.2f %%)\n\n", 2 * a.u.total(), 200 * a.u.total() / size);
  std::printf("%-50s %-12s %10s %11s %12s %7s\n", "cause", "distribution", "value", "sensitivity", "contribution",
              "share");
  for (const Row& row : a.rows) {
    std::printf("%-50s %-12s %10.4g %11.4g %10.4f %% %5.1f %%\n", (row.kind + ": " + row.cause).c_str(),
                row.distribution.c_str(), row.value, row.sensitivity, 100 * row.contribution, 100 * row.share);
  }
  std::printf(
      "\nND filters: worst case %.1f %% (root sum of squares), standard %.1f %%, no more than a factor %.2f (linear "
      "sum)\n",
      100 * scale.filters_worst_case(), 100 * scale.filters_standard(), std::exp(scale.filters_linear_bound()));
  const FactorStatistics& mc = a.verdict.monte_carlo.factor;
  std::printf("95 %% interval of true over reported value:\n");
  print_interval(mc.symmetric, "Monte Carlo");
  print_interval(mc.shortest, "Monte Carlo, shortest");
  print_interval(lognormal(scale, r).symmetric, "lognormal");
  print_interval(second_order(scale, r).symmetric, "second order");
  print_interval(first_order(scale, r).symmetric, "first order");
  std::printf("mean %.4f, standard deviation %.4f (exact); %zu trials%s\n", a.exact.mean, a.exact.sd,
              a.verdict.monte_carlo.trials, a.verdict.monte_carlo.converged ? "" : ", not converged");
  std::printf(
      "first order against Monte Carlo (JCGM 101, clause 8): d_low %.4f, d_high %.4f, delta %.4f: first order %s\n",
      a.verdict.d_low, a.verdict.d_high, a.verdict.delta,
      a.verdict.valid ? "is good enough" : "FAILS, use the Monte Carlo interval");
}

// Which sets of filters, from the largest alone to all, would have to be calibrated how well.
void print_targets(const Answer& a, double target, nlohmann::json* json) {
  const double now = a.u.total() / std::abs(a.u.value);
  const std::vector<FilterTarget> sets = filter_targets(a.factors, a.u.relative_additive(), target);
  if (json != nullptr) {
    (*json)["filter_targets"] = nlohmann::json::array();
    for (const FilterTarget& t : sets) {
      (*json)["filter_targets"].push_back(
          {{"filters", t.filters}, {"u_od", t.u_od ? nlohmann::json(*t.u_od) : nlohmann::json(nullptr)}});
    }
    return;
  }
  if (now <= target) {
    std::printf("%.3g %% in total: reached, it is %.3g %%\n", 100 * target, 100 * now);
    return;
  }
  const bool reachable =
      std::any_of(sets.begin(), sets.end(), [](const FilterTarget& t) { return t.u_od.has_value(); });
  if (!reachable)
    std::printf("%.3g %% in total: out of reach of any filter's calibration; now it is %.3g %%\n", 100 * target,
                100 * now);
  for (const FilterTarget& t : sets) {
    if (!t.u_od) continue;
    std::string names;
    for (const std::string& n : t.filters) names += (names.empty() ? "" : ", ") + n;
    std::printf("%.3g %% in total: calibrate %s to a standard uncertainty of %.5f OD%s\n", 100 * target, names.c_str(),
                *t.u_od, t.filters.size() > 1 ? " each" : "");
  }
}

// Mean relative contributions over the map, where the value stands out of its noise.
struct MapMeans {
  std::vector<std::pair<std::string, double>> causes;
  double mean = 0, sd = 0, pixels = 0;  // of the total without scale
};

MapMeans means_of(const BrdfMap& map) {
  constexpr double kStandsOut = 10;
  const Grid<float> total = per_pixel_uncertainty(map);
  MapMeans out;
  out.causes = {{"random", 0}};
  if (!map.u_pose_per_sr.empty()) out.causes.emplace_back("structured: pose", 0);
  const std::size_t first = out.causes.size();
  for (const StructuredCause& s : map.structured) out.causes.emplace_back("structured: " + s.meaning, 0);
  double square = 0;
  for (std::size_t i = 0; i < total.size(); ++i) {
    const double f = map.brdf_per_sr[i];
    if (map.mask[i] != 0 || !(f > kStandsOut * total[i])) continue;
    out.pixels += 1;
    out.mean += total[i] / f;
    square += std::pow(total[i] / f, 2);
    out.causes[0].second += map.u_random_per_sr[i] / f;
    if (first > 1) out.causes[1].second += map.u_pose_per_sr[i] / f;
    for (std::size_t k = 0; k < map.structured.size(); ++k)
      out.causes[first + k].second += std::abs(map.structured[k].sensitivity_per_sr[i]) / f;
  }
  out.mean /= out.pixels;
  out.sd = std::sqrt(std::max(0.0, square / out.pixels - out.mean * out.mean));
  for (auto& c : out.causes) c.second /= out.pixels;
  return out;
}

void print_means(const MapMeans& m) {
  if (m.pixels == 0) {
    std::printf("no pixel stands 10 standard uncertainties out of its noise\n\n");
    return;
  }
  std::printf(
      "per pixel, scale excluded: %.2f %% on average, standard deviation %.2f %%, over %.0f pixels with f > 10 u\n",
      100 * m.mean, 100 * m.sd, m.pixels);
  for (const auto& [cause, mean] : m.causes) std::printf("  %-60s %8.3f %%\n", cause.c_str(), 100 * mean);
  std::printf("\nintegrated scatter on the detector:\n");
}

void answer_pair(const MapUncertainty& uncertainty, const PixelSum& a, const PixelSum& b, nlohmann::json* json) {
  const Ratio ratio = ratio_of(uncertainty, a, b);
  const double covariance = uncertainty.covariance(a, b);
  constexpr double kSigmas = 3;
  if (!(std::abs(uncertainty.of(b).value) > kSigmas * uncertainty.of(b).without_scale()))
    std::fprintf(stderr, "note: the second value may be 0: the ratio's uncertainty, to first order, means nothing\n");
  if (json != nullptr) {
    (*json)["and"] = {{"value", uncertainty.of(b).value}, {"u", uncertainty.of(b).total()}, {"covariance", covariance},
                      {"correlation", ratio.correlation}, {"ratio", ratio.value},           {"u_ratio", ratio.u}};
    return;
  }
  std::printf("\nsecond value %.6g, standard uncertainty %.3g; covariance %.4g, correlation %.4f\n",
              uncertainty.of(b).value, uncertainty.of(b).total(), covariance, ratio.correlation);
  std::printf("ratio %.6g, standard uncertainty %.3g (%.3f %%): the scale cancels\n", ratio.value, ratio.u,
              100 * ratio.u / std::abs(ratio.value));
}

void run(const Options& o) {
  const BrdfMap map = read_map_fits(o.map);
  const auto uncertainty = [&] {
    try {
      return MapUncertainty(map);
    } catch (const Error& e) {
      throw with_context(o.map, e);
    }
  }();
  const Region all{0, 0, map.mask.columns() - 1, map.mask.rows() - 1};
  const Region region = o.whole_map ? all : region_of(o.pixel.empty() ? o.region : o.pixel);
  const PixelSum power = power_in(map, region), sum = o.whole_map ? power : mean_over(map, region);
  const Answer answer = answer_for(uncertainty, map, sum, o.digits);
  const SumUncertainty scattered = uncertainty.of(power);
  std::optional<PixelSum> other;  // before anything is printed: it may be outside the map
  if (!o.other.empty()) other = o.whole_map ? power_in(map, region_of(o.other)) : mean_over(map, region_of(o.other));
  nlohmann::json json = answer_json(answer);
  nlohmann::json* target = o.json ? &json : nullptr;
  json["pixels"] = sum.pixels.size();
  json["scattered_power"] = {
      {"value", scattered.value}, {"u", scattered.total()}, {"u_without_scale", scattered.without_scale()}};
  if (o.whole_map) {
    const MapMeans means = means_of(map);
    json["per_pixel"] = {{"mean", means.mean}, {"sd", means.sd}, {"pixels", means.pixels}};
    if (!o.json) print_means(means);
  }
  if (!o.json) {
    print_answer(answer, o.whole_map ? "" : " sr^-1");
    std::printf("power into the %zu pixel%s: %.6g of the incident, standard uncertainty %.3g (%.3g without scale)\n",
                power.pixels.size(), power.pixels.size() == 1 ? "" : "s", scattered.value, scattered.total(),
                scattered.without_scale());
  }
  if (other) answer_pair(uncertainty, sum, *other, target);
  if (o.target_percent > 0) print_targets(answer, o.target_percent / 100, target);
  if (o.json) std::printf("%s\n", json.dump(2).c_str());
}

}  // namespace

void setup_uncertainty(CLI::App& app, const Invocation&) {
  auto o = std::make_shared<Options>();
  CLI::App* verb =
      app.add_subcommand("uncertainty", "budget, intervals and covariance of a pixel, a region or a whole map");
  verb->add_option("map", o->map, "measured map (FITS)")->required();
  CLI::Option_group* what = verb->add_option_group("what");
  what->add_option("--pixel", o->pixel, "COLUMN,ROW")->delimiter(',')->expected(2);
  what->add_option("--region", o->region, "first COLUMN,ROW and last COLUMN,ROW: mean over their pixels")
      ->delimiter(',')
      ->expected(4);
  what->add_flag("--map", o->whole_map, "averages over the map, and the scatter integrated over it");
  what->require_option(1);
  verb->add_option("--and", o->other, "a second pixel or region: covariance and ratio")
      ->delimiter(',')
      ->expected(2, 4)
      ->check(CLI::Number);
  verb->add_option("--target-percent", o->target_percent,
                   "which filter calibration brings the total standard uncertainty to this")
      ->check(positive_number());
  verb->add_option("--digits", o->digits, "significant digits of u that first order must hold (JCGM 101, clause 8)")
      ->check(CLI::Range(1, 2))
      ->capture_default_str();
  verb->add_flag("--json", o->json, "print the result as JSON on standard output");
  verb->callback([o] {
    if (o->other.size() == 3)
      throw CLI::ValidationError("--and", "needs COLUMN,ROW or first COLUMN,ROW,last COLUMN,ROW");
    run(*o);
  });
}

}  // namespace scatmap::tools
