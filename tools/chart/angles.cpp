#include "tools/chart/angles.h"

#include <numbers>

#include "scatmap/angles/angle_map.h"
#include "tools/chart/error_sample.h"
#include "tools/chart/scene.h"
#include "tools/chart/timing.h"

namespace scatmap::tools {
namespace {

constexpr int kErrorStep = 37;  // every so many pixels are compared with the reference, which takes microseconds each

std::string size_text(const Instrument& in) { return std::to_string(in.columns) + " x " + std::to_string(in.rows); }

// Distance on the sphere, rad: theta, and phi as far as it moves the direction.
double direction_error(double theta, double phi, const synth::PixelTruth& truth) {
  constexpr long double kPi = std::numbers::pi_v<long double>;
  const long double across = std::sin(truth.theta_s_rad) * std::remainder(phi - truth.phi_s_rad, 2 * kPi);
  return static_cast<double>(std::hypot(theta - truth.theta_s_rad, across));
}

struct Errors {
  ErrorSample rad, px;
};

// In pixels: over the angle between neighbours, the root of the pixel's solid angle.
Errors errors_of(const Grid<double>& theta, const Grid<double>& phi, const Instrument& in, const Pose& pose) {
  const synth::TruthGeometry truth(bench_of(in), pose.stage_rad * 180 / std::numbers::pi_v<long double>,
                                   pose.arm_rad * 180 / std::numbers::pi_v<long double>);
  Errors out;
  for (std::size_t i = 0; i < theta.size(); i += kErrorStep) {
    const int row = static_cast<int>(i) / in.columns, column = static_cast<int>(i) % in.columns;
    const auto pixel = truth.pixel(column, row);
    if (!pixel) continue;
    const double error = direction_error(theta[i], phi[i], *pixel);
    out.rad.add(error, column, row);
    out.px.add(error / std::sqrt(static_cast<double>(pixel->solid_angle_sr)), column, row);
  }
  return out;
}

ChartRow exact_row(const Instrument& in, const Pose& pose, int threads, double seconds) {
  const SampleView view = sample_view(in, pose);
  ChartRow row;
  row.method = "exact";
  row.size = size_text(in);
  row.threads = threads;
  row.time = with_threads(threads, [&] {
    return time_per_item(static_cast<std::size_t>(in.columns) * static_cast<std::size_t>(in.rows), seconds,
                         [&] { keep(angle_map(view, in.rows, in.columns).theta_s_rad.data()); });
  });
  const AngleMap map = angle_map(view, in.rows, in.columns);
  const Errors errors = errors_of(map.theta_s_rad, map.phi_s_rad, in, pose);
  row.largest_error = errors.px.largest();
  row.p99_error = errors.px.percentile(99);
  row.largest_error_rad = errors.rad.largest();
  row.worst_at = errors.px.worst_at();
  row.note = "angles, solid angle and mask";
  return row;
}

}  // namespace

std::vector<Chart> chart_angles(const ChartSettings& s) {
  Chart chart{"angles", "Angle maps: both scatter angles of every pixel",
              "pixel",  "direction error",
              "px",     "long double, separate derivation",
              {},       {},
              {}};
  for (const auto& [columns, rows] : {std::pair{1024, 1024}, std::pair{s.instrument.columns, s.instrument.rows}}) {
    const Instrument in = resized(s.instrument, columns, rows);
    for (const int threads : {1, 2}) chart.rows.push_back(exact_row(in, s.pose, threads, s.seconds_per_method));
  }
  return {chart};
}

}  // namespace scatmap::tools
