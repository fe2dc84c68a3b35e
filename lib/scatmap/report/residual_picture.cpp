#include "scatmap/report/residual_picture.h"

#include <algorithm>
#include <cmath>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"

namespace scatmap {
namespace {

constexpr int kWidth = 1200, kLeft = 85, kRight = 30, kTop = 55, kBottom = 120;  // px
constexpr int kLegend = 28;                                                      // px above the picture's lower edge
constexpr double kLongestShare = 1.0 / 12;                                       // of the diagonal
constexpr std::size_t kMostLabels = 12;

std::string text(double number) { return number_text(number); }
std::string text(int number) { return std::to_string(number); }

// The largest of 1, 2, 5 times a power of ten that is not above x.
double round_down(double x) {
  const double decade = std::pow(10, std::floor(std::log10(x)));
  return (x / decade >= 5 ? 5 : x / decade >= 2 ? 2 : 1) * decade;
}

double length(const SpotResidual& s) { return std::hypot(s.along_columns_px, s.along_rows_px); }

// Nine in ten of those that took part are shorter.
double typical_length(const std::vector<SpotResidual>& spots) {
  std::vector<double> lengths;
  for (const SpotResidual& s : spots) {
    if (!s.left_out && length(s) > 0) lengths.push_back(length(s));
  }
  if (lengths.empty()) return 1;
  const auto at = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() * 9 / 10);
  std::nth_element(lengths.begin(), at, lengths.end());
  return *at;
}

// One block of the data file: spots of one kind, as column, row, arrow along columns and rows.
struct Kind {
  const char* name;
  const char* colour;
  bool direct, left_out;
};
constexpr Kind kKinds[] = {
    {"mirror", "#1f3b73", false, false}, {"direct beam", "#d95f02", true, false}, {"left out", "#b2182b", false, true}};

bool belongs(const SpotResidual& s, const Kind& kind) {
  return kind.left_out ? s.left_out : !s.left_out && s.direct == kind.direct;
}

// Arrows of spots left out end where they would leave the picture's sense: at three typical lengths.
std::string block(const std::vector<SpotResidual>& spots, const Kind& kind, double scale, double longest) {
  std::string out;
  for (const SpotResidual& s : spots) {
    if (!belongs(s, kind)) continue;
    const bool drawn = std::isfinite(length(s)) && (!s.left_out || length(s) * scale <= longest);
    out += text(s.column_px) + " " + text(s.row_px) + " " + text(drawn ? scale * s.along_columns_px : 0.0) + " " +
           text(drawn ? scale * s.along_rows_px : 0.0) + "\n";
  }
  return out;
}

struct Curves {
  std::string data, commands;
};

Curves curves(const std::vector<SpotResidual>& spots, double scale, double longest) {
  Curves out;
  int index = 0;
  for (const Kind& kind : kKinds) {
    const std::string lines = block(spots, kind, scale, longest);
    if (lines.empty()) continue;
    out.data += lines + "\n\n";
    const std::string from = "data index " + text(index++), colour = std::string(" lc rgb '") + kind.colour + "'";
    out.commands += (out.commands.empty() ? "" : ", ") + from +
                    " using 1:2:3:4 with vectors head size screen 0.006,20 filled lw 1.3" + colour + " notitle, " +
                    from + " using 1:2 with points " + (kind.left_out ? "pt 2 ps 1.2 lw 2" : "pt 7 ps 0.5") + colour +
                    " title '" + kind.name + "'";
  }
  return out;
}

std::string labels(const std::vector<SpotResidual>& spots) {
  const auto count = std::count_if(spots.begin(), spots.end(), [](const SpotResidual& s) { return s.left_out; });
  if (static_cast<std::size_t>(count) > kMostLabels) return {};
  std::string out;
  for (const SpotResidual& s : spots) {
    if (!s.left_out) continue;
    const std::string words =
        std::isfinite(s.sigmas) ? text(std::round(10 * s.sigmas) / 10) + " σ" : std::string("not on the detector");
    out += "set label " + gnuplot_text(words) + " at " + text(s.column_px) + "," + text(s.row_px) +
           " offset 1.1,0.1 left noenhanced tc rgb '#b2182b' font ',10' front\n";
  }
  return out;
}

// Below the frame at its right end: an arrow of a round length, and what it stands for.
std::string scale_arrow(double residual_px, double scale, double width_px, const std::string& legend) {
  const double drawn_share = residual_px * scale / width_px;
  std::string out = "set arrow from graph " + text(0.98 - drawn_share) + ", screen " + legend +
                    " to graph 0.98, screen " + legend +
                    " lw 2 lc rgb '#404040' head size screen 0.008,20 filled front\n";
  return out + "set label " +
         gnuplot_text(text(residual_px) + " px of residual; arrows are " + text(scale) +
                      " times the distance on the frame") +
         " at graph " + text(0.965 - drawn_share) + ", screen " + legend + " right noenhanced tc rgb '#404040'\n";
}

}  // namespace

void draw_spot_residuals(const std::vector<SpotResidual>& spots, int columns, int rows, const std::string& title,
                         const std::filesystem::path& target, const PictureOptions& options) {
  if (spots.empty()) throw Error({target.string(), "there is no spot to draw", {}, {}});
  const double longest = kLongestShare * std::hypot(columns, rows), typical = typical_length(spots);
  const double scale = round_down(longest / typical);
  const int width = kWidth - kLeft - kRight;
  const double margin = 0.06 * std::max(columns, rows), shape = (rows + 2 * margin) / (columns + 2 * margin);
  const int height = std::clamp(static_cast<int>(width * shape), 200, 1400);
  Plot plot;
  plot.width_px = kWidth;
  plot.height_px = kTop + height + kBottom;
  const auto screen_y = [&](int from_top) { return text(1 - static_cast<double>(from_top) / plot.height_px); };
  const std::string legend = screen_y(plot.height_px - kLegend);
  std::string& s = plot.script;
  s = "set border lc rgb '#404040'\nset tics out nomirror\nset grid back lt 1 lc rgb '#ececec'\n";
  s += "set lmargin at screen " + text(static_cast<double>(kLeft) / kWidth) + "\nset rmargin at screen " +
       text(static_cast<double>(kLeft + width) / kWidth) + "\n";
  s += "set tmargin at screen " + screen_y(kTop) + "\nset bmargin at screen " + screen_y(kTop + height) + "\n";
  // The frame, and around it room for arrows that begin at its edge.
  s += "set xrange [" + text(-0.5 - margin) + ":" + text(columns - 0.5 + margin) + "]\nset yrange [" +
       text(rows - 0.5 + margin) + ":" + text(-0.5 - margin) + "]\n";
  s += "set object 1 rectangle from -0.5,-0.5 to " + text(columns - 0.5) + "," + text(rows - 0.5) +
       " behind fillcolor rgb '#f7f7f7' fillstyle solid border lc rgb '#404040'\n";
  s += "set xlabel 'column (px)'\nset ylabel 'row (px)'\n";
  s += "set title " + gnuplot_text(title) + " noenhanced offset 0,-0.3\n";
  s += "set key at screen " + text(static_cast<double>(kLeft) / kWidth) + "," + legend +
       " left center horizontal Left reverse "
       "samplen 1.5 maxrows 1\n";
  s += labels(spots) + scale_arrow(round_down(typical), scale, columns + 2 * margin, legend);
  const Curves drawn = curves(spots, scale, 3 * longest);
  plot.data = drawn.data;
  s += "plot " + drawn.commands + "\n";
  write_picture(plot, target, options);
}

}  // namespace scatmap
