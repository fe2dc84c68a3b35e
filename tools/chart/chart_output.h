#pragma once
#include <filesystem>
#include <string>

#include "scatmap/report/gnuplot.h"
#include "tools/chart/chart.h"

namespace scatmap::tools {

/// Processor, instruction set, threads, compiler and version: what the figures hold for.
std::string machine_text();

/// For people: one line per method, rivals marked, methods on the Pareto front starred.
std::string chart_text(const Chart& chart);
/// One line per row, with a header line.
std::string chart_csv(const Chart& chart);
/// Error against time, both logarithmic: the rows of one thread and of the last row's size.
Plot chart_plot(const Chart& chart);

/// Whether no other own method of the same size and threads is both faster and at least as accurate.
bool on_pareto_front(const Chart& chart, const ChartRow& row);

}  // namespace scatmap::tools
