#include <algorithm>
#include <cmath>
#include <vector>

#include "scatmap/base/number_text.h"
#include "tools/chart/chart_output.h"

namespace scatmap::tools {
namespace {

struct Box {
  double left, right, bottom, top;
};

// Errors of 0 have no place on a logarithmic axis: they stand on its lowest decade.
double drawn_error(double error, double floor) { return error > floor ? error : floor; }

std::vector<const ChartRow*> drawn_rows(const Chart& chart) {
  std::vector<const ChartRow*> out;
  if (chart.rows.empty()) return out;
  for (const ChartRow& row : chart.rows) {
    if (row.threads == 1 && row.size == chart.rows.back().size && row.time.minimum_ns > 0 && row.largest_error >= 0 &&
        std::isfinite(row.largest_error))
      out.push_back(&row);
  }
  return out;
}

double smallest_error(const Chart& chart, const std::vector<const ChartRow*>& rows) {
  double smallest = HUGE_VAL;
  for (const ChartRow* row : rows) {
    if (row->largest_error > 0) smallest = std::min(smallest, row->largest_error);
  }
  for (const ChartLine& line : chart.error_lines) smallest = std::min(smallest, line.value);
  return std::isfinite(smallest) ? smallest : 1e-16;
}

// So far right that the names of the points end inside the picture.
double right_for_names(const std::vector<const ChartRow*>& rows, double left, double right) {
  constexpr double kGap = 0.015, kCharacter = 0.0078, kLeastShare = 0.4;  // of the picture's width
  double decades = std::log10(right / left);
  for (const ChartRow* row : rows) {
    const double share = 1 - kGap - kCharacter * static_cast<double>(row->method.size());
    decades = std::max(decades, std::log10(row->time.minimum_ns / left) / std::max(kLeastShare, share));
  }
  return left * std::pow(10, decades);
}

Box box_of(const Chart& chart, const std::vector<const ChartRow*>& rows, double floor) {
  Box box{HUGE_VAL, 0, floor, 0};
  const auto time = [&](double ns) {
    box.left = std::min(box.left, ns);
    box.right = std::max(box.right, ns);
  };
  for (const ChartRow* row : rows) {
    time(row->time.minimum_ns);
    box.top = std::max(box.top, drawn_error(row->largest_error, floor));
    if (row->bound) box.top = std::max(box.top, *row->bound);
  }
  for (const ChartLine& line : chart.time_lines) time(line.value);
  for (const ChartLine& line : chart.error_lines) box.top = std::max(box.top, line.value);
  const double left = box.left / 2;
  return {left, right_for_names(rows, left, box.right * 6), box.bottom / 10, box.top * 30};
}

std::string label_at(const std::string& text, double x, double y, const std::string& options) {
  return "set label " + gnuplot_text(text) + " at " + number_text(x) + "," + number_text(y) + " noenhanced " + options +
         "\n";
}

// A point near the line in the picture's right half: the line's name goes to the left.
bool crowded_at_right(const std::vector<const ChartRow*>& rows, const Box& box, double error) {
  const double middle = std::sqrt(box.left * box.right), near = 0.06 * std::log10(box.top / box.bottom);
  return std::any_of(rows.begin(), rows.end(), [&](const ChartRow* row) {
    return row->time.minimum_ns > middle && std::abs(std::log10(row->largest_error / error)) < near;
  });
}

std::string lines_text(const Chart& chart, const std::vector<const ChartRow*>& rows, const Box& box) {
  std::string out;
  for (const ChartLine& line : chart.time_lines) {
    out += "set arrow from " + number_text(line.value) + "," + number_text(box.bottom) + " to " +
           number_text(line.value) + "," + number_text(box.top) + " nohead dt 2 lc rgb '#808080'\n";
    out += label_at(line.label, line.value, box.bottom, "rotate left offset 0.8,0.5 font ',11' tc rgb '#606060'");
  }
  for (const ChartLine& line : chart.error_lines) {
    out += "set arrow from " + number_text(box.left) + "," + number_text(line.value) + " to " + number_text(box.right) +
           "," + number_text(line.value) + " nohead dt 4 lc rgb '#b2182b'\n";
    const bool left = crowded_at_right(rows, box, line.value);
    out +=
        label_at(line.label, left ? box.left : box.right, line.value,
                 std::string(left ? "left offset 0.5,0.6" : "right offset -0.5,0.6") + " font ',11' tc rgb '#b2182b'");
  }
  return out;
}

constexpr double kMostPlain = 1e4;  // longer times are labelled as powers of ten

std::string frame_text(const Chart& chart, const Box& box) {
  const std::string unit = chart.error_unit.empty() ? "relative" : chart.error_unit;
  return "set logscale xy\nset border 3 lc rgb '#404040'\nset tics out nomirror\n"
         "set format x '" +
         std::string(box.right > kMostPlain ? "10^{%L}" : "%g") +
         "'\nset format y '10^{%L}'\nset grid lc rgb '#e8e8e8' lt 1\n"
         "set title " +
         gnuplot_text(chart.title) +
         " font ',16' noenhanced\n"
         "set xlabel " +
         gnuplot_text("time per " + chart.item + ", ns (one thread, " + chart.rows.back().size + ")") +
         "\nset ylabel " + gnuplot_text("largest " + chart.error_name + ", " + unit) + " noenhanced\nset label " +
         gnuplot_text("errors against " + chart.reference) +
         " at graph 0.5,1.02 center noenhanced font ',11' tc rgb '#606060'\n"
         "set label " +
         gnuplot_text(machine_text()) +
         " at screen 0.99,0.018 right font ',9' tc rgb '#808080'\n"
         "set bmargin 8\nset tmargin 4\nset key at screen 0.45,0.058 center horizontal reverse Left\nset xrange [" +
         number_text(box.left) + ":" + number_text(box.right) + "]\nset yrange [" + number_text(box.bottom) + ":" +
         number_text(box.top) + "]\n";
}

// In order of time.
std::vector<const ChartRow*> front_of(const Chart& chart, const std::vector<const ChartRow*>& rows) {
  std::vector<const ChartRow*> front;
  for (const ChartRow* row : rows) {
    if (on_pareto_front(chart, *row)) front.push_back(row);
  }
  std::sort(front.begin(), front.end(),
            [](const ChartRow* a, const ChartRow* b) { return a->time.minimum_ns < b->time.minimum_ns; });
  return front;
}

std::string front_block(const std::vector<const ChartRow*>& front, double floor) {
  std::string out = "$front << EOD\n";
  for (const ChartRow* row : front)
    out += number_text(row->time.minimum_ns) + " " + number_text(drawn_error(row->largest_error, floor)) + "\n";
  return out + "EOD\n";
}

std::string points_block(const char* name, const std::vector<const ChartRow*>& rows, double floor, bool rivals) {
  std::string out = std::string("$") + name + " << EOD\n";
  for (const ChartRow* row : rows) {
    if (row->rival != rivals) continue;
    out += number_text(row->time.minimum_ns) + " " + number_text(drawn_error(row->largest_error, floor)) + " " +
           number_text(row->time.minimum_ns + row->time.spread_ns) + "\n";
  }
  return out + "EOD\n";
}

std::string bounds_block(const std::vector<const ChartRow*>& rows) {
  std::string out = "$bounds << EOD\n";
  for (const ChartRow* row : rows) {
    if (row->bound) out += number_text(row->time.minimum_ns) + " " + number_text(*row->bound) + "\n";
  }
  return out + "EOD\n";
}

// What is drawn, and only that, has a place in the legend.
std::string plot_command(const std::vector<const ChartRow*>& rows, std::size_t front_points) {
  const auto any = [&](auto&& is) { return std::any_of(rows.begin(), rows.end(), is); };
  const bool own = any([](const ChartRow*r) { return !r->rival; }),
             rivals = any([](const ChartRow*r) { return r->rival; });
  std::string out;
  const auto add = [&](bool drawn, const std::string& what) {
    if (drawn) out += (out.empty() ? "plot " : ", ") + what;
  };
  const std::string bar = " (bar to the 90th percentile)";
  add(front_points >= 2, "$front with steps lc rgb '#80a0d0' lw 2 title 'Pareto front'");
  add(any([](const ChartRow* r) { return r->bound.has_value(); }),
      "$bounds with points pt 10 ps 1.4 lc rgb '#d08020' title 'bound'");
  add(rivals, "$rivals using 1:2:1:3 with xerrorbars pt 5 lw 0.7 lc rgb '#909090' title 'others" +
                  (own ? " (the same)" : bar) + "'");
  add(own, "$own using 1:2:1:3 with xerrorbars pt 7 ps 1.3 lw 0.7 lc rgb '#104080' title 'scatmap" + bar + "'");
  return (out.empty() ? "plot NaN notitle" : out) + "\n";
}

// Above and right of its point, clear of the spread's bar; higher where a neighbour's label is in the way.
std::string names_text(const std::vector<const ChartRow*>& rows, const Box& box, double floor) {
  constexpr double kHeight = 0.03, kCharacter = 0.011;  // of the picture's height and width
  struct Placed {
    double x, y, width;
  };
  std::vector<const ChartRow*> ordered = rows;
  std::sort(ordered.begin(), ordered.end(),
            [](const ChartRow* a, const ChartRow* b) { return a->largest_error < b->largest_error; });
  const double decades_up = std::log10(box.top / box.bottom), decades_right = std::log10(box.right / box.left);
  std::vector<Placed> placed;
  std::string out;
  for (const ChartRow* row : ordered) {
    Placed at{std::log10(row->time.minimum_ns / box.left) / decades_right,
              std::log10(drawn_error(row->largest_error, floor) / box.bottom) / decades_up,
              kCharacter * static_cast<double>(row->method.size())};
    for (const Placed& other : placed) {
      const bool beside = at.x > other.x + other.width || other.x > at.x + at.width;
      if (!beside && std::abs(at.y - other.y) < kHeight) at.y = other.y + kHeight;
    }
    placed.push_back(at);
    out += label_at(row->method, row->time.minimum_ns, box.bottom * std::pow(10, at.y * decades_up),
                    std::string("left offset 0.9,0.6 font ',12' tc rgb '") + (row->rival ? "#606060'" : "#104080'"));
  }
  return out;
}

}  // namespace

Plot chart_plot(const Chart& chart) {
  const std::vector<const ChartRow*> rows = drawn_rows(chart);
  const double floor = std::pow(10, std::floor(std::log10(smallest_error(chart, rows))) - 1);
  const Box box = box_of(chart, rows, floor);
  const std::vector<const ChartRow*> front = front_of(chart, rows);
  Plot plot;
  plot.script = frame_text(chart, box) + lines_text(chart, rows, box) + names_text(rows, box, floor) +
                front_block(front, floor) + points_block("own", rows, floor, false) +
                points_block("rivals", rows, floor, true) + bounds_block(rows) + plot_command(rows, front.size());
  return plot;
}

}  // namespace scatmap::tools
