#include "tools/chart/lens.h"

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>

#include "scatmap/angles/angle_method.h"
#include "scatmap/angles/lens.h"
#include "scatmap/angles/opencv_lens.h"
#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"
#include "tools/chart/error_sample.h"
#include "tools/chart/lens_truth.h"
#include "tools/chart/timing.h"

namespace scatmap::tools {
namespace {

constexpr int kSize = 1024, kMrcalSize = 128;

// A strong wide-angle lens over 50 degrees.
OpencvLens chart_lens_of(int size) {
  const double scale = static_cast<double>(size) / kSize;
  return {
      1100 * scale, 1090 * scale, 510.3 * scale, 520.7 * scale, {-0.25, 0.06, 1e-3, -2e-3, 0.01, 0.02, -0.01, 0.004}};
}

class LensChart {
 public:
  explicit LensChart(double seconds)
      : seconds_(seconds), lens_(chart_lens_of(kSize)), x_(kSize, kSize), y_(kSize, kSize) {}

  ChartRow newton() {
    ChartRow row = begun("Newton", false, kSize);
    row.bound = kLensMaxError_px;
    row.note = "rays";
    row.time = time_per_item(x_.size(), seconds_, [&] {
      for (int r = 0; r < kSize; ++r) unproject_row(lens_, r, {0, kSize}, {x_.row(r), y_.row(r), {}});
      keep(x_.data());
    });
    add_errors(row);
    return row;
  }

  ChartRow newton_with_angles() {
    ChartRow row = newton_row_of_angles();
    for (int r = 0; r < kSize; ++r) unproject_row(lens_, r, {0, kSize}, {x_.row(r), y_.row(r), {}});
    add_errors(row);
    return row;
  }

  // The iteration of OpenCV's undistortPoints, x = (distorted − tangential)/radial, with its default of 5 steps.
  ChartRow fixed_point(int steps) {
    ChartRow row = begun("fixed point, " + std::to_string(steps) + " steps", true, kSize);
    row.note = "as OpenCV's undistortPoints; rays";
    row.time = time_per_item(x_.size(), seconds_, [&] {
      for (int r = 0; r < kSize; ++r) {
        for (int c = 0; c < kSize; ++c) iterate(c, r, steps);
      }
      keep(x_.data());
    });
    add_errors(row);
    return row;
  }

  // Through the module, on a small frame: it takes microseconds. Every pixel costs three rays there.
  std::optional<ChartRow> mrcal() {
    const OpencvLens lens = chart_lens_of(kMrcalSize);
    const std::filesystem::path file =
        std::filesystem::temp_directory_path() / ("scatmap-chart-" + std::to_string(getpid()) + ".cameramodel");
    write_text_file(file, cameramodel_of(lens, kMrcalSize, kMrcalSize), Overwrite::kForce);
    const std::optional<ChartRow> row = mrcal_row(lens, file);
    std::filesystem::remove(file);
    return row;
  }

 private:
  static ChartRow begun(std::string name, bool rival, int size) {
    ChartRow row;
    row.method = std::move(name);
    row.size = std::to_string(size) + " x " + std::to_string(size);
    row.rival = rival;
    return row;
  }

  ChartRow newton_row_of_angles() {
    ChartRow row = begun("Newton, both angles", false, kSize);
    row.bound = kLensMaxError_px;
    row.note = "error of the rays";
    Grid<double> theta(kSize, kSize), phi(kSize, kSize);
    const Matrix3<double> turn = rotation_y<double>(0.35);
    row.time = time_per_item(x_.size(), seconds_, [&] {
      for (int r = 0; r < kSize; ++r) {
        AngleRow<double> out;
        out.theta_s_rad = theta.row(r);
        out.phi_s_rad = phi.row(r);
        lens_angle_row(lens_, turn, r, {0, kSize}, out);
      }
      keep(theta.data());
    });
    return row;
  }

  void iterate(int c, int r, int steps) {
    const auto& k = lens_.k;
    const double x0 = (c - lens_.cx) / lens_.fx, y0 = (r - lens_.cy) / lens_.fy;
    double x = x0, y = y0;
    for (int i = 0; i < steps; ++i) {
      const double r2 = x * x + y * y;
      const double inverse = (1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]))) / (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4])));
      const double dx = 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x), dy = k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y;
      x = (x0 - dx) * inverse;
      y = (y0 - dy) * inverse;
    }
    x_(r, c) = x;
    y_(r, c) = y;
  }

  void add_errors(ChartRow& row) const {
    ErrorSample px;
    for (int r = 0; r < kSize; r += 3) {
      for (int c = 0; c < kSize; ++c) {
        const LensPoint p = projected(lens_, x_(r, c), y_(r, c));
        px.add(static_cast<double>(std::hypot(p.x - c, p.y - r)), c, r);
      }
    }
    put(px, row);
  }

  static void put(const ErrorSample& px, ChartRow& row) {
    row.largest_error = px.largest();
    row.p99_error = px.percentile(99);
    row.worst_at = px.worst_at();
  }

  std::optional<ChartRow> mrcal_row(const OpencvLens& lens, const std::filesystem::path& file) const try {
    ChartRow row = begun("mrcal_unproject", true, kSize);
    row.note = "measured on 128 x 128; rays";
    std::optional<LensRays> rays;
    const std::size_t count = 3 * kMrcalSize * kMrcalSize;
    row.time = with_threads(1, [&] {
      return time_per_item(count, seconds_,
                           [&] { rays = load_lens_rays(file, kMrcalSize, kMrcalSize, LensInverse::kMrcal); });
    });
    ErrorSample px;
    for (int r = 0; r < kMrcalSize; ++r) {
      for (int c = 0; c < kMrcalSize; ++c) {
        const Vector3<double>& ray = rays->direction(r, c);
        const LensPoint p = projected(lens, ray.x() / ray.z(), ray.y() / ray.z());
        px.add(static_cast<double>(std::hypot(p.x - c, p.y - r)), c, r);
      }
    }
    put(px, row);
    return row;
  } catch (const Error&) {
    return std::nullopt;  // the module is not installed
  }

  double seconds_;
  OpencvLens lens_;
  Grid<double> x_, y_;
};

}  // namespace

std::vector<Chart> chart_lens(const ChartSettings& s) {
  Chart chart;
  chart.job = "lens";
  chart.title = "Lens with 8 parameters (OPENCV8): the ray of every pixel";
  chart.item = "pixel";
  chart.error_name = "projection error of the ray";
  chart.error_unit = "px";
  chart.reference = "the forward model in long double";
  LensChart lens(s.seconds_per_method);
  if (const auto mrcal = lens.mrcal()) chart.rows.push_back(*mrcal);
  for (const int steps : {5, 20}) chart.rows.push_back(lens.fixed_point(steps));
  chart.rows.push_back(lens.newton());
  chart.rows.push_back(lens.newton_with_angles());
  chart.error_lines = {{"default tolerance", kDefaultTolerance_px}};
  return {chart};
}

}  // namespace scatmap::tools
