#include <tbb/global_control.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <thread>

#include "scatmap/base/number_text.h"
#include "scatmap/base/provenance.h"
#include "tools/chart/chart_output.h"
#include "tools/chart/text_cells.h"

namespace scatmap::tools {
namespace {

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  }
  return "processor not named by the system";
}

std::string instruction_set() {
#if defined(__x86_64__) && defined(__GNUC__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return "AVX-512";
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? "AVX2" : "SSE2";
#else
  return "its baseline";
#endif
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, std::abs(value) >= 0.01 && std::abs(value) < 1e5 ? "%.4g" : "%.2e", value);
  return std::isnan(value) ? "-" : text;
}

}  // namespace

std::string machine_text() {
  return processor_name() + ", " + instruction_set() + ", " + std::to_string(std::thread::hardware_concurrency()) +
         " threads; g++ " __VERSION__ ", scatmap " + version();
}

bool on_pareto_front(const Chart& chart, const ChartRow& row) {
  if (row.rival || !(row.largest_error >= 0) || !(row.time.minimum_ns > 0)) return false;
  for (const ChartRow& other : chart.rows) {
    if (&other == &row || other.rival || other.size != row.size || other.threads != row.threads) continue;
    if (other.time.minimum_ns < row.time.minimum_ns && other.largest_error <= row.largest_error) return false;
  }
  return true;
}

std::string chart_text(const Chart& chart) {
  const std::string unit = chart.error_unit.empty() ? "" : " " + chart.error_unit;
  std::string out = chart.title + "\n" + chart.error_name + unit + " against " + chart.reference + "; time in ns per " +
                    chart.item + "\n";
  out += padded("method", 34) + padded("size", 14) + padded("threads", 8) + padded("ns min", 10) +
         padded("spread", 10) + padded("first", 10) + padded("largest", 10) + padded("99 %", 10) + padded("rad", 10) +
         padded("bound", 10) + "worst at\n";
  for (const ChartRow& row : chart.rows) {
    out += padded((on_pareto_front(chart, row) ? "* " : "  ") + row.method + (row.rival ? " (rival)" : ""), 34) +
           padded(row.size, 14) + padded(std::to_string(row.threads), 8) +
           padded(short_number(row.time.minimum_ns), 10) + padded(short_number(row.time.spread_ns), 10) +
           padded(short_number(row.time.first_ns), 10) + padded(short_number(row.largest_error), 10) +
           padded(short_number(row.p99_error), 10) +
           padded(row.largest_error_rad ? short_number(*row.largest_error_rad) : "-", 10) +
           padded(row.bound ? short_number(*row.bound) : "-", 10) + row.worst_at;
    if (!row.note.empty()) out += (row.worst_at.empty() ? "" : "; ") + row.note;
    out += "\n";
  }
  for (const ChartLine& line : chart.time_lines) out += line.label + ": " + short_number(line.value) + " ns\n";
  for (const ChartLine& line : chart.error_lines) out += line.label + ": " + short_number(line.value) + unit + "\n";
  return out;
}

std::string chart_csv(const Chart& chart) {
  std::string out =
      "job,method,rival,size,threads,ns_min,ns_spread,ns_first,largest_error,p99_error,error_unit,largest_error_rad,"
      "bound,"
      "pareto,worst_at,note,reference,machine\n";
  const auto number = [](double v) { return std::isnan(v) ? std::string() : number_text(v); };
  for (const ChartRow& row : chart.rows) {
    out += chart.job + "," + quoted(row.method) + (row.rival ? ",1," : ",0,") + quoted(row.size) + "," +
           std::to_string(row.threads) + "," + number(row.time.minimum_ns) + "," + number(row.time.spread_ns) + "," +
           number(row.time.first_ns) + "," + number(row.largest_error) + "," + number(row.p99_error) + "," +
           quoted(chart.error_unit) + "," + (row.largest_error_rad ? number(*row.largest_error_rad) : "") + "," +
           (row.bound ? number(*row.bound) : "") + (on_pareto_front(chart, row) ? ",1," : ",0,") +
           quoted(row.worst_at) + "," + quoted(row.note) + "," + quoted(chart.reference) + "," +
           quoted(machine_text()) + "\n";
  }
  return out;
}

}  // namespace scatmap::tools
