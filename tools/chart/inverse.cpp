#include "tools/chart/inverse.h"

#include <algorithm>
#include <cmath>

#include "scatmap/angles/angle_method.h"
#include "scatmap/angles/direction_pixels.h"
#include "scatmap/angles/frame_extent.h"
#include "tools/chart/direction_error.h"
#include "tools/chart/scene.h"
#include "tools/chart/timing.h"

namespace scatmap::tools {
namespace {

// Directions of every pixel, in long double rounded once: where they meet the detector is known.
class InverseChart {
 public:
  InverseChart(const ChartSettings& s, const Instrument& in)
      : in_(in),
        seconds_(s.seconds_per_method),
        view_(sample_view(in, s.pose)),
        extent_(frame_extent(view_, in.rows, in.columns)),
        x_(in.rows, in.columns),
        y_(in.rows, in.columns),
        z_(in.rows, in.columns),
        column_(in.rows, in.columns),
        row_(in.rows, in.columns) {
    for (int r = 0; r < in.rows; ++r) {
      for (int c = 0; c < in.columns; ++c) set_direction(r, c);
    }
  }

  ChartRow vector() {
    ChartRow row = begun("vector", false);
    row.bound = kInverseMaxError_rad * extent_.spread / extent_.pixel_step_rad;
    measure(row, [&] {
      pixels_of_directions(view_, in_.rows, in_.columns, {all(x_), all(y_), all(z_)}, {all(column_), all(row_)});
    });
    return row;
  }

  ChartRow one_by_one() {
    ChartRow row = begun("one by one", false);
    measure(row, [&] {
      for (std::size_t i = 0; i < x_.size(); ++i) {
        const auto p = pixel_of_direction(view_, {x_[i], y_[i], z_[i]});
        column_[i] = p ? p->column : NAN;
        row_[i] = p ? p->row : NAN;
      }
    });
    return row;
  }

  // A linear system per direction: column, row and distance as unknowns.
  ChartRow linear_system() {
    ChartRow row = begun("3 x 3 system per direction", true);
    measure(row, [&] {
      for (std::size_t i = 0; i < x_.size(); ++i) {
        Matrix3<double> m;
        m << view_.column_step, view_.row_step, Vector3<double>(-x_[i], -y_[i], -z_[i]);
        const Vector3<double> solved = m.inverse() * -view_.origin;
        column_[i] = solved.x();
        row_[i] = solved.y();
      }
    });
    return row;
  }

 private:
  static std::span<double> all(Grid<double>& g) { return {g.data(), g.size()}; }
  void set_direction(int r, int c) {
    long double p[3], length2 = 0;
    for (int k = 0; k < 3; ++k) {
      p[k] = view_.origin[k] + static_cast<long double>(c) * view_.column_step[k] +
             static_cast<long double>(r) * view_.row_step[k];
      length2 += p[k] * p[k];
    }
    const long double length = std::sqrt(length2);
    x_(r, c) = static_cast<double>(p[0] / length);
    y_(r, c) = static_cast<double>(p[1] / length);
    z_(r, c) = static_cast<double>(p[2] / length);
  }
  ChartRow begun(std::string name, bool rival) const {
    ChartRow row;
    row.method = std::move(name);
    row.size = size_text(in_);
    row.rival = rival;
    return row;
  }
  template <class Work>
  void measure(ChartRow& out, Work&& work) {
    out.time = time_per_item(x_.size(), seconds_, [&] {
      work();
      keep(column_.data());
    });
    constexpr int kStep = 7;
    ErrorSample px;
    for (int r = 0; r < in_.rows; r += kStep) {
      for (int c = 0; c < in_.columns; c += kStep) px.add(std::hypot(column_(r, c) - c, row_(r, c) - r), c, r);
    }
    out.largest_error = px.largest();
    out.p99_error = px.percentile(99);
    out.largest_error_rad = px.largest() * extent_.pixel_step_rad;
    out.worst_at = px.worst_at();
  }

  Instrument in_;
  double seconds_;
  SampleView view_;
  FrameExtent extent_;
  Grid<double> x_, y_, z_, column_, row_;
};

}  // namespace

std::vector<Chart> chart_inverse(const ChartSettings& s) {
  Chart chart;
  chart.job = "inverse";
  chart.title = "Inverse: the pixel that sees a direction";
  chart.item = "direction";
  chart.error_name = "position error";
  chart.error_unit = "px";
  chart.reference = "the pixels that the directions were made from, in long double";
  InverseChart sized(s, resized(s.instrument, 1024, 1024));
  chart.rows = {sized.vector(), sized.one_by_one(), sized.linear_system()};
  chart.error_lines = {{"default tolerance", kDefaultTolerance_px}};
  return {chart};
}

}  // namespace scatmap::tools
