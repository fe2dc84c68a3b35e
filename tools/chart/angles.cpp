#include "tools/chart/angles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scatmap/angles/angle_method.h"
#include "scatmap/angles/angle_uncertainty.h"
#include "tools/chart/direction_error.h"
#include "tools/chart/scene.h"
#include "tools/chart/timing.h"

namespace scatmap::tools {
namespace {

constexpr std::size_t kErrorStep = 37;  // every so many pixels are compared with the reference: microseconds each
constexpr double kTileTolerance_px = 0.01;

// One size of frame with its maps, filled again and again.
class AngleChart {
 public:
  AngleChart(const ChartSettings& s, const Instrument& in)
      : in_(in),
        pose_(s.pose),
        seconds_(s.seconds_per_method),
        view_(sample_view(in, s.pose)),
        truth_(bench_of(in), s.pose.stage_rad * 180 / std::numbers::pi_v<long double>,
               s.pose.arm_rad * 180 / std::numbers::pi_v<long double>),
        wide_{0, {in.rows, in.columns}, {in.rows, in.columns}, {}, {}},
        narrow_{0, {in.rows, in.columns}, {in.rows, in.columns}, {}, {}} {}

  ChartRow method(AngleMethod method, double tolerance_px, int threads) {
    const AngleChoice choice = with_method(method, view_, in_.rows, in_.columns, tolerance_px);
    ChartRow row = begun(std::string(to_string(method)), threads);
    if (method == AngleMethod::kTile) row.note = "for " + short_text(tolerance_px) + " px";
    if (std::isfinite(choice.bound_px)) row.bound = choice.bound_px;
    // The choice is made anew each time: it is part of the cost.
    if (fills_single(method)) {
      row.time = time(threads, [&] {
        write_angle_map(view_, with_method(method, view_, in_.rows, in_.columns, tolerance_px), narrow_);
        keep(narrow_.theta_s_rad.data());
      });
      errors(narrow_).into(row);
    } else {
      row.time = time(threads, [&] {
        write_angle_map(view_, choice, wide_);
        keep(wide_.theta_s_rad.data());
      });
      errors(wide_).into(row);
    }
    return row;
  }

  // What a first program would hold: rotate, normalise, acos, atan2.
  ChartRow plain_acos(int threads) {
    ChartRow row = begun("libm acos, atan2", threads);
    row.rival = true;
    row.time = time(threads, [&] {
      each_pixel([](const Vector3<double>& ray, double& theta, double& phi) {
        const Vector3<double> unit = ray / ray.norm();
        theta = std::acos(unit.z());
        phi = std::atan2(unit.y(), unit.x()) + std::numbers::pi;
      });
    });
    errors(wide_).into(row);
    return row;
  }

  double fill_ns(bool single) {
    const float f = 1.25f;
    return time(1,
                [&] {
                  if (single) {
                    std::fill(narrow_.theta_s_rad.begin(), narrow_.theta_s_rad.end(), f);
                    std::fill(narrow_.phi_s_rad.begin(), narrow_.phi_s_rad.end(), f);
                    keep(narrow_.phi_s_rad.data());
                  } else {
                    std::fill(wide_.theta_s_rad.begin(), wide_.theta_s_rad.end(), f);
                    std::fill(wide_.phi_s_rad.begin(), wide_.phi_s_rad.end(), f);
                    keep(wide_.phi_s_rad.data());
                  }
                })
        .minimum_ns;
  }

 private:
  static std::string short_text(double v) {
    std::string text = std::to_string(v);
    text.erase(text.find_last_not_of('0') + 1);
    return text;
  }
  ChartRow begun(std::string name, int threads) const {
    ChartRow row;
    row.method = std::move(name);
    row.size = size_text(in_);
    row.threads = threads;
    return row;
  }
  template <class Work>
  Timing time(int threads, Work&& work) const {
    return with_threads(threads, [&] { return time_per_item(wide_.theta_s_rad.size(), seconds_, work); });
  }
  template <class Work>
  void each_pixel(Work&& work) {
    for (int r = 0; r < in_.rows; ++r) {
      for (int c = 0; c < in_.columns; ++c) work(view_.pixel(c, r), wide_.theta_s_rad(r, c), wide_.phi_s_rad(r, c));
    }
    keep(wide_.theta_s_rad.data());
  }
  template <class T>
  DirectionErrors errors(const AngleMapOf<T>& map) const {
    DirectionErrors out;
    for (std::size_t i = 0; i < map.theta_s_rad.size(); i += kErrorStep) {
      const int row = static_cast<int>(i) / in_.columns, column = static_cast<int>(i) % in_.columns;
      const auto pixel = truth_.pixel(column, row);
      if (!pixel) continue;
      out.add(direction_error(map.theta_s_rad[i], map.phi_s_rad[i], pixel->theta_s_rad, pixel->phi_s_rad),
              pixel_step_rad(view_, column, row), column, row);
    }
    return out;
  }

  Instrument in_;
  Pose pose_;
  double seconds_;
  SampleView view_;
  synth::TruthGeometry truth_;
  AngleMap wide_;
  AngleMapOf<float> narrow_;
};

}  // namespace

std::vector<Chart> chart_angles(const ChartSettings& s) {
  Chart chart;
  chart.job = "angles";
  chart.title = "Angle maps: both scatter angles of every pixel";
  chart.item = "pixel";
  chart.error_name = "direction error";
  chart.error_unit = "px";
  chart.reference = "long double, separate derivation";
  for (const auto& [columns, rows] : {std::pair{1024, 1024}, std::pair{s.instrument.columns, s.instrument.rows}}) {
    AngleChart sized(s, resized(s.instrument, columns, rows));
    for (const int threads : {1, 2}) {
      for (const AngleMethod method : angle_methods())
        chart.rows.push_back(sized.method(method, kTileTolerance_px, threads));
    }
    chart.rows.push_back(sized.plain_acos(1));
    chart.time_lines = {{"filling two float maps", sized.fill_ns(true)},
                        {"filling two double maps", sized.fill_ns(false)}};
  }
  const auto sigma_px = smallest_direction_sigma_px(s.instrument, s.pose);
  if (sigma_px)
    chart.error_lines.push_back({"the calibration's own uncertainty", *sigma_px});
  else
    chart.error_lines.push_back({"default tolerance", kDefaultTolerance_px});
  return {chart};
}

}  // namespace scatmap::tools
