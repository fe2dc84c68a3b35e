#include "scatmap/report/picture.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/compare/pixel_directions.h"
#include "scatmap/report/picture_raster.h"

namespace scatmap {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 1200, kLeft = 80, kRight = 115, kTop = 45, kBottom = 65, kGap = 30;       // px
constexpr int kTallestMap = 900, kProfileHeight = 330, kProfileRight = 25, kProfileBottom = 32;  // px
constexpr int kMostCells = 1200;  // along a picture's width
constexpr double kMostDecades = 7;
constexpr double kResidualRange = 5;

constexpr const char* kStyle =
    "set multiplot\n"
    "set border lc rgb '#404040'\nset tics out nomirror\n"
    // viridis: equal steps look equal, also in grey and to colour-blind eyes
    "set palette defined (0 '#440154', 1 '#48186a', 2 '#472d7b', 3 '#424086', 4 '#3b528b', 5 '#33638d', 6 '#2c728e', "
    "7 '#26828e', 8 '#21918c', 9 '#1fa088', 10 '#28ae80', 11 '#3fbc73', 12 '#5ec962', 13 '#84d44b', 14 '#addc30', "
    "15 '#d8e219', 16 '#fde725')\n";
constexpr const char* kDiverging =
    "set palette defined (0 '#053061', 1 '#2166ac', 2 '#4393c3', 3 '#92c5de', 4 '#d1e5f0', 5 '#f7f7f7', "
    "6 '#fddbc7', 7 '#f4a582', 8 '#d6604d', 9 '#b2182b', 10 '#67001f')\n";
constexpr const char* kMaskedColour = "#8c8c8c";

std::string text(double number) { return number_text(number); }
std::string text(int number) { return std::to_string(number); }

// Script and data of a picture under construction; margins are set in pixels from the top left.
class Canvas {
 public:
  explicit Canvas(int height_px) {
    plot_.width_px = kWidth;
    plot_.height_px = height_px;
    plot_.script = kStyle;
  }
  void add(const std::string& commands) { plot_.script += commands; }
  void frame(int left, int top, int width, int height) {
    add("set lmargin at screen " + text(static_cast<double>(left) / kWidth) + "\n");
    add("set rmargin at screen " + text(static_cast<double>(left + width) / kWidth) + "\n");
    add("set tmargin at screen " + text(1 - static_cast<double>(top) / plot_.height_px) + "\n");
    add("set bmargin at screen " + text(1 - static_cast<double>(top + height) / plot_.height_px) + "\n");
  }
  void colour_bar(int left, int top, int width, int height) {
    add("set colorbox user origin screen " + text(static_cast<double>(left) / kWidth) + "," +
        text(1 - static_cast<double>(top + height) / plot_.height_px) + " size screen " +
        text(static_cast<double>(width) / kWidth) + "," + text(static_cast<double>(height) / plot_.height_px) + "\n");
  }
  /// Appends float32 values; gives the words that make gnuplot read them.
  std::string data(const std::vector<float>& values) {
    const std::size_t start = plot_.data.size();
    plot_.data.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    return std::string(" endian=") + (std::endian::native == std::endian::little ? "little" : "big") +
           " skip=" + std::to_string(start);
  }
  void write(const fs::path& target, const PictureOptions& options) {
    add("unset multiplot\n");
    write_picture(plot_, target, options);
  }

 private:
  Plot plot_;
};

struct Range {
  double low, high;
};

// Logarithmic scale for values: from the decade below their 5th percentile, so that the floor is seen, to their
// highest.
Range log_range(std::vector<float> values, const std::string& where) {
  std::erase_if(values, [](float v) { return !(v > 0) || !std::isfinite(v); });
  if (values.empty()) throw Error({where, "has no positive value to draw", {}, {}});
  const auto low = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 20);
  std::nth_element(values.begin(), low, values.end());
  const double high = static_cast<double>(*std::max_element(low, values.end()));
  const double floor = std::pow(10, std::floor(std::log10(static_cast<double>(*low))));
  return {std::clamp(floor, high * std::pow(10, -kMostDecades), high / 100), high};
}

// The range of the one whose floor is higher: a model without noise goes on downwards where a measurement ends.
Range common(const Range& a, const Range& b) { return {std::max(a.low, b.low), std::max(a.high, b.high)}; }

void raise_to(float floor, std::vector<float>& values) {
  for (float& v : values) {
    if (v < floor) v = floor;
  }
}

// The maps' rectangles: equal scales on both axes.
struct MapLayout {
  int left, width, height;
};

MapLayout map_layout(const Raster& first, std::size_t panels) {
  const int count = static_cast<int>(panels);
  const int widest = (kWidth - kLeft - kRight - (count - 1) * kGap) / count;
  const double aspect = first.height_deg() / first.width_deg();
  const int width = std::max(60, std::min(widest, static_cast<int>(kTallestMap / aspect)));
  const int height = std::clamp(static_cast<int>(width * aspect), 60, kTallestMap);
  return {kLeft + (kWidth - kLeft - kRight - count * width - (count - 1) * kGap) / 2, width, height};
}

void axes(Canvas& canvas, const Raster& r, const std::string& title, bool first) {
  const double left = r.first_x_deg - r.step_x_deg / 2, top = r.first_y_deg - r.step_y_deg / 2;
  canvas.add("set title " + gnuplot_text(title) + " noenhanced offset 0,-0.4\n");
  canvas.add("set xrange [" + text(left) + ":" + text(left + r.width_deg()) + "]\n");
  canvas.add("set yrange [" + text(top + r.height_deg()) + ":" + text(top) + "]\n");
  canvas.add("set xlabel 'in-plane angle from frame centre (deg)'\n");
  canvas.add(first ? "set ylabel 'out-of-plane angle (deg)' offset 0.5,0\nset ytics format '%g'\n"
                   : "unset ylabel\nset ytics format ''\n");
  canvas.add(std::string("set object 1 rectangle from graph 0,0 to graph 1,1 behind fillcolor rgb '") + kMaskedColour +
             "' fillstyle solid noborder\n");
}

void image(Canvas& canvas, const Raster& r) {
  const std::string source = canvas.data(r.values);
  canvas.add("plot data binary array=(" + text(r.columns) + "," + text(r.rows) + ") format='%float32'" + source +
             " origin=(" + text(r.first_x_deg) + "," + text(r.first_y_deg) + ") dx=" + text(r.step_x_deg) +
             " dy=" + text(r.step_y_deg) + " using 1 with image notitle\n");
}

std::vector<Raster> rasters(const std::vector<MapPanel>& panels) {
  if (panels.empty()) throw Error({"picture", "there is no map to draw", {}, {}});
  std::vector<Raster> out;
  for (const MapPanel& p : panels) {
    const SampleView view = mean_view(*p.map);
    out.push_back(raster(p.map->brdf_per_sr, p.map->mask, view, kMostCells / static_cast<int>(panels.size())));
  }
  return out;
}

// Maps side by side at `top`, the colour bar after the last.
void add_maps(Canvas& canvas, const std::vector<MapPanel>& panels, std::vector<Raster> drawn, int top) {
  Range range = log_range(drawn.front().values, panels.front().title);
  for (std::size_t k = 1; k < drawn.size(); ++k) range = common(range, log_range(drawn[k].values, panels[k].title));
  const MapLayout layout = map_layout(drawn.front(), panels.size());
  canvas.add("set logscale cb\nset cbtics format '10^{%L}'\nset cblabel 'BRDF (sr^{-1})'\n");
  canvas.add("set cbrange [" + text(range.low) + ":" + text(range.high) + "]\nunset colorbox\n");
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    raise_to(static_cast<float>(range.low), drawn[k].values);
    const int left = layout.left + static_cast<int>(k) * (layout.width + kGap);
    canvas.frame(left, top, layout.width, layout.height);
    axes(canvas, drawn[k], panels[k].title, k == 0);
    if (k + 1 == drawn.size()) canvas.colour_bar(left + layout.width + 15, top, 18, layout.height);
    image(canvas, drawn[k]);
  }
  canvas.add("unset object 1\n");
}

struct Curve {
  std::vector<float> angle_and_value;
  std::vector<float> value;
};

Curve curve(const Profile& p) {
  Curve c;
  for (std::size_t i = 0; i < p.size(); ++i) {
    c.angle_and_value.push_back(static_cast<float>(p.angle_deg[i]));
    c.angle_and_value.push_back(static_cast<float>(p.value_per_sr[i]));
    c.value.push_back(static_cast<float>(p.value_per_sr[i]));
  }
  return c;
}

std::string draw_curve(Canvas& canvas, Curve c, double floor, const std::string& style) {
  for (std::size_t i = 1; i < c.angle_and_value.size(); i += 2) {
    if (c.angle_and_value[i] < static_cast<float>(floor)) c.angle_and_value[i] = static_cast<float>(floor);
  }
  return "data binary record=(" + std::to_string(c.value.size()) + ") format='%float32%float32'" +
         canvas.data(c.angle_and_value) + " using 1:2 with lines " + style;
}

// The model broad and pale below, the measurement thin and dark above: where they agree, both are seen.
void add_profile(Canvas& canvas, const ProfilePanel& panel, int top, bool last) {
  const Curve measured = curve(*panel.measured);
  Range range = log_range(measured.value, panel.title);
  std::string curves;
  if (panel.modelled) {
    const Curve modelled = curve(*panel.modelled);
    range.high = std::max(range.high, log_range(modelled.value, panel.title).high);
    curves = draw_curve(canvas, modelled, range.low, "lw 4 lc rgb '#fdae6b' title 'modelled'") + ", ";
  }
  curves += draw_curve(canvas, measured, range.low, "lw 1.2 lc rgb '#1f3b73' title 'measured'");
  canvas.frame(kLeft, top, kWidth - kLeft - kProfileRight, kProfileHeight - kTop - kProfileBottom);
  canvas.add("set title " + gnuplot_text(panel.title) + " noenhanced offset 0,-0.4\n");
  canvas.add(
      "set logscale y\nset ytics format '10^{%L}'\nset grid x y back lt 1 lc rgb '#e0e0e0'\nset xrange [*:*] "
      "noextend\n");
  canvas.add("set yrange [" + text(range.low) + ":" + text(2 * range.high) + "]\n");
  canvas.add("set ylabel 'BRDF (sr^{-1})' offset 0.5,0\n");
  canvas.add(std::string("set xlabel ") + (last ? "'angle from the peak (deg)'" : "''") + "\n");
  canvas.add("set key at graph 1,1.02 right bottom maxrows 1 nobox\nplot " + curves + "\n");
}

int add_profiles(Canvas& canvas, const std::vector<ProfilePanel>& panels, int top) {
  for (const ProfilePanel& p : panels) {
    add_profile(canvas, p, top + kTop, &p == &panels.back());
    top += kProfileHeight;
  }
  return top;
}

int profiles_height(const std::vector<ProfilePanel>& panels) {
  return static_cast<int>(panels.size()) * kProfileHeight + kBottom - kProfileBottom;  // the last one has a label below
}

}  // namespace

void draw_map(const std::vector<MapPanel>& panels, const fs::path& target, const PictureOptions& options) {
  std::vector<Raster> drawn = rasters(panels);
  Canvas canvas(kTop + map_layout(drawn.front(), panels.size()).height + kBottom);
  add_maps(canvas, panels, std::move(drawn), kTop);
  canvas.write(target, options);
}

void draw_profiles(const std::vector<ProfilePanel>& panels, const fs::path& target, const PictureOptions& options) {
  if (panels.empty()) throw Error({"picture", "there is no profile to draw", {}, {}});
  Canvas canvas(profiles_height(panels));
  add_profiles(canvas, panels, 0);
  canvas.write(target, options);
}

void draw_overview(const std::vector<MapPanel>& maps, const std::vector<ProfilePanel>& profiles, const fs::path& target,
                   const PictureOptions& options) {
  std::vector<Raster> drawn = rasters(maps);
  const int maps_height = kTop + map_layout(drawn.front(), maps.size()).height + kBottom;
  Canvas canvas(maps_height + profiles_height(profiles));
  add_maps(canvas, maps, std::move(drawn), kTop);
  add_profiles(canvas, profiles, maps_height);
  canvas.write(target, options);
}

void draw_residual(const Residual& residual, const BrdfMap& map, const std::string& title, const fs::path& target,
                   const PictureOptions& options) {
  const Raster drawn = raster(residual.normalised, map.mask, mean_view(map), kMostCells);
  const MapLayout layout = map_layout(drawn, 1);
  Canvas canvas(kTop + layout.height + kBottom);
  const std::string blocks =
      drawn.block > 1 ? ", mean of " + text(drawn.block) + " × " + text(drawn.block) + " pixels" : "";
  canvas.add(kDiverging);
  canvas.add("set cbrange [" + text(-kResidualRange) + ":" + text(kResidualRange) + "]\n");
  canvas.add("set cblabel '(measured − modelled) / u" + blocks + "'\n");
  canvas.frame(layout.left, kTop, layout.width, layout.height);
  axes(canvas, drawn, title, true);
  canvas.colour_bar(layout.left + layout.width + 15, kTop, 18, layout.height);
  image(canvas, drawn);
  canvas.write(target, options);
}

}  // namespace scatmap
