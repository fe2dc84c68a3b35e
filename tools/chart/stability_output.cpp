#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "scatmap/base/number_text.h"
#include "tools/chart/stability.h"
#include "tools/chart/text_cells.h"

namespace scatmap::tools {
namespace {

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return std::isnan(value) ? "-" : text;
}

const char* colour(Verdict v) {
  switch (v) {
    case Verdict::kHolds:
      return "#c7e9c0";
    case Verdict::kIllConditioned:
      return "#e5f5a0";
    case Verdict::kFallsBack:
      return "#c6dbef";
    case Verdict::kRefuses:
      return "#d9d9d9";
    case Verdict::kFails:
      break;
  }
  return "#fb6a4a";
}

template <class Key>
std::vector<std::string> in_order(const std::vector<StabilityCell>& cells, const std::string& job, Key key) {
  std::vector<std::string> out;
  for (const StabilityCell& c : cells) {
    if (c.job == job && std::find(out.begin(), out.end(), key(c)) == out.end()) out.push_back(key(c));
  }
  return out;
}

// As the pictures name the unit of a job's errors.
std::string unit_in_words(const std::vector<StabilityCell>& cells, const std::string& job) {
  const auto cell = std::find_if(cells.begin(), cells.end(), [&](const StabilityCell& c) { return c.job == job; });
  if (cell == cells.end() || cell->unit.empty()) return "relative";
  if (cell->unit == "prob.") return "probability";
  return cell->unit == "sigma" ? "standard uncertainties" : cell->unit;
}

constexpr const char* kLegend[] = {
    "green: holds, within its bound; yellow: ill-conditioned, beyond it by no more than rounding the inputs does to "
    "the",
    "truth; blue: falls back on a method that holds; grey: refuses, with a reason; red: FAILS"};

std::string cell_text(const StabilityCell& c) {
  if (c.verdict == Verdict::kRefuses) return "refuses";
  if (c.verdict == Verdict::kFallsBack && std::isnan(c.worst_error)) return "falls back";
  return short_number(c.worst_error) + (std::isnan(c.bound) ? "" : " / " + short_number(c.bound));
}

}  // namespace

const char* to_string(Verdict v) {
  switch (v) {
    case Verdict::kHolds:
      return "holds";
    case Verdict::kIllConditioned:
      return "ill-conditioned";
    case Verdict::kFallsBack:
      return "falls back";
    case Verdict::kRefuses:
      return "refuses";
    case Verdict::kFails:
      break;
  }
  return "FAILS";
}

namespace {

std::string totals(const std::vector<StabilityCell>& cells) {
  std::set<std::string> regimes;
  std::map<Verdict, std::size_t> count;
  for (const StabilityCell& c : cells) {
    regimes.insert(c.job + ": " + c.regime);
    ++count[c.verdict];
  }
  std::string out = std::to_string(cells.size()) + " cells in " + std::to_string(regimes.size()) + " regimes:";
  for (const Verdict v :
       {Verdict::kHolds, Verdict::kIllConditioned, Verdict::kFallsBack, Verdict::kRefuses, Verdict::kFails})
    out += std::string(v == Verdict::kHolds ? " " : ", ") + to_string(v) + " " + std::to_string(count[v]);
  return out + "\n";
}

}  // namespace

std::string stability_text(const std::vector<StabilityCell>& cells) {
  std::string out = padded("job", 13) + padded("regime", 46) + padded("method", 16) + padded("worst", 9) +
                    padded("bound", 9) + padded("unit", 6) + padded("x ulp", 8) + padded("x sigma", 8) + "verdict\n";
  for (const StabilityCell& c : cells) {
    out += padded(c.job, 13) + padded(c.regime, 46) + padded(c.method, 16) + padded(short_number(c.worst_error), 9) +
           padded(short_number(c.bound), 9) + padded(c.unit, 6) + padded(short_number(c.amplification_ulp), 8) +
           padded(short_number(c.amplification_sigma), 8) + to_string(c.verdict) +
           (c.reason.empty() ? "" : ": " + c.reason) + "\n";
  }
  return out + totals(cells);
}

std::string stability_csv(const std::vector<StabilityCell>& cells) {
  std::string out = "job,regime,method,worst_error,bound,unit,amplification_ulp,amplification_sigma,verdict,reason\n";
  const auto number = [](double v) { return std::isnan(v) ? std::string() : number_text(v); };
  for (const StabilityCell& c : cells) {
    out += c.job + "," + quoted(c.regime) + "," + quoted(c.method) + "," + number(c.worst_error) + "," +
           number(c.bound) + "," + c.unit + "," + number(c.amplification_ulp) + "," + number(c.amplification_sigma) +
           "," + to_string(c.verdict) + "," + quoted(c.reason) + "\n";
  }
  return out;
}

Plot stability_plot(const std::vector<StabilityCell>& cells, const std::string& job) {
  const auto regimes = in_order(cells, job, [](const StabilityCell& c) { return c.regime; });
  const auto methods = in_order(cells, job, [](const StabilityCell& c) { return c.method; });
  Plot plot;
  plot.width_px = std::max(860, 420 + 150 * static_cast<int>(methods.size()));
  plot.height_px = 146 + 26 * static_cast<int>(regimes.size());
  std::string& s = plot.script;
  s = "unset border\nunset key\nset lmargin at screen " + number_text(380.0 / plot.width_px) +
      "\nset rmargin at screen 0.99\nset tmargin at screen " + number_text(1 - 80.0 / plot.height_px) +
      "\nset bmargin at screen " + number_text(56.0 / plot.height_px) +
      "\nset xrange [0:" + std::to_string(methods.size()) + "]\nset yrange [" + std::to_string(regimes.size()) +
      ":0]\nunset tics\n" + "set label " +
      gnuplot_text("Where the methods of " + job + " hold: worst error / bound, " + unit_in_words(cells, job)) +
      " at screen 0.5,screen " + number_text(1 - 22.0 / plot.height_px) + " center font ',15' noenhanced\n";
  for (int line = 0; line < 2; ++line)
    s += "set label " + gnuplot_text(kLegend[line]) + " at screen 0.5,screen " +
         number_text((30.0 - 16.0 * line) / plot.height_px) + " center font ',10' tc rgb '#606060' noenhanced\n";
  for (std::size_t m = 0; m < methods.size(); ++m)
    s += "set label " + gnuplot_text(methods[m]) + " at " + number_text(static_cast<double>(m) + 0.5) +
         ",-0.5 center font ',12' noenhanced\n";
  for (std::size_t r = 0; r < regimes.size(); ++r)
    s += "set label " + gnuplot_text(regimes[r]) + " at -0.04," + number_text(static_cast<double>(r) + 0.5) +
         " right font ',11' noenhanced\n";
  int object = 0;
  for (const StabilityCell& c : cells) {
    if (c.job != job) continue;
    const auto x = std::find(methods.begin(), methods.end(), c.method) - methods.begin();
    const auto y = std::find(regimes.begin(), regimes.end(), c.regime) - regimes.begin();
    s += "set object " + std::to_string(++object) + " rect from " + std::to_string(x) + "," + std::to_string(y) +
         " to " + std::to_string(x + 1) + "," + std::to_string(y + 1) + " fc rgb '" + colour(c.verdict) +
         "' fs solid border lc rgb '#ffffff'\n" + "set label " + gnuplot_text(cell_text(c)) + " at " +
         number_text(static_cast<double>(x) + 0.5) + "," + number_text(static_cast<double>(y) + 0.5) +
         " center front font ',10' noenhanced\n";
  }
  s += "plot NaN\n";
  return plot;
}

}  // namespace scatmap::tools
