#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "scatmap/angles/angle_method.h"
#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/direction_pixels.h"
#include "scatmap/angles/frame_extent.h"
#include "scatmap/angles/linear_map.h"
#include "scatmap/angles/tile_map.h"
#include "scatmap/base/units.h"
#include "tools/chart/angle_regimes.h"
#include "tools/chart/scene.h"
#include "tools/chart/stability.h"
#include "tools/chart/stability_large.h"

namespace scatmap::tools {
namespace {

constexpr int kSide = 16384, kBand = 32;  // a band is a row of tiles
constexpr const char* kRegime = "16384 x 16384 frame, rows and bands of it";
constexpr std::array kRows{0, 1, 5461, 8191, 8192, 12000, 16382, 16383};
constexpr int kColumnStride = 13;

AngleSetup setup() {
  AngleSetup s;
  s.bench.columns = s.bench.rows = kSide;
  s.bench.pitch_um = {5.5, 5.5};
  s.bench.distance_mm = 325;
  return s;
}

SampleView view_of(const AngleSetup& s) {
  return sample_view(instrument_of(s.bench), Pose{s.stage_deg * kRadPerDeg, s.arm_deg * kRadPerDeg});
}

// The frame from a row on.
SampleView shifted(SampleView view, int row) {
  view.origin += row * view.row_step;
  return view;
}

using Angles = std::array<std::vector<double>, 2>;

template <class T>
Angles as_doubles(std::span<const T> theta, std::span<const T> phi) {
  return {std::vector<double>(theta.begin(), theta.end()), std::vector<double>(phi.begin(), phi.end())};
}

Angles single_row(const SampleView& view, int row) {
  std::vector<float> theta(kSide), phi(kSide);
  AngleRow<float> out;
  out.theta_s_rad = theta;
  out.phi_s_rad = phi;
  angle_row(view, row, {0, kSide}, out);
  return as_doubles<float>(theta, phi);
}

Angles linear_row(const SampleView& view, int row) {
  std::vector<float> theta(kSide), phi(kSide);
  LinearMap(view, kSide, kSide).row(row, theta, phi);
  return as_doubles<float>(theta, phi);
}

Angles exact_row(const SampleView& view, int row) {
  Angles out;
  for (int c = 0; c < kSide; ++c) {
    const PixelAngles a = pixel_angles(view, c, row);
    out[0].push_back(a.theta_s_rad);
    out[1].push_back(a.phi_s_rad);
  }
  return out;
}

// By the plan of the whole frame, and with its tiles.
template <class T>
Angles tile_row(const SampleView& view, const AngleChoice& choice, int row) {
  const int first = row / kBand * kBand;
  AngleMapOf<T> map{0, {kBand, kSide}, {kBand, kSide}, {}, {}};
  write_tile_map(shifted(view, first), choice.tiles, map);
  return as_doubles<T>(std::as_const(map.theta_s_rad).row(row - first), std::as_const(map.phi_s_rad).row(row - first));
}

Angles angles_of(const SampleView& view, const AngleChoice& choice, int row) {
  switch (choice.method) {
    case AngleMethod::kLinear:
      return linear_row(view, row);
    case AngleMethod::kTile:
      return tile_row<float>(view, choice, row);
    case AngleMethod::kSingle:
      return single_row(view, row);
    case AngleMethod::kVector:
      return tile_row<double>(view, choice, row);
    default:
      return exact_row(view, row);
  }
}

double turn(double theta, double phi, const synth::Vec3& truth) {
  const long double t = theta, azimuth = static_cast<long double>(phi) - std::numbers::pi_v<long double>;
  return static_cast<double>(std::hypot(std::sin(t) * std::cos(azimuth) - truth.x,
                                        std::sin(t) * std::sin(azimuth) - truth.y, std::cos(t) - truth.z));
}

StabilityCell begun(const char* job, std::string method, const char* unit) {
  StabilityCell cell;
  cell.job = job;
  cell.regime = kRegime;
  cell.method = std::move(method);
  cell.unit = unit;
  return cell;
}

void judge(StabilityCell& cell) {
  cell.reason = "amplification as for the row of 16384 pixels";
  if (!std::isfinite(cell.bound)) {
    cell.verdict = Verdict::kRefuses;
    cell.reason = "states no bound here, so that no tolerance picks it";
  } else if (cell.worst_error <= cell.bound) {
    cell.verdict = Verdict::kHolds;
  }
}

StabilityCell angle_cell(AngleMethod method) {
  StabilityCell cell = begun("angles", std::string(to_string(method)), "rad");
  constexpr double kTolerance_px = 0.01;
  const AngleSetup s = setup();
  const SampleView view = view_of(s);
  const AngleChoice choice = with_method(method, view, kSide, kSide, kTolerance_px);
  cell.bound =
      choice.bound_rad + kAngleMaxError_rad * frame_extent(view, kSide, kSide).spread / std::sin(incidence_angle(view));
  const synth::TruthGeometry truth = truth_of(s);
  cell.worst_error = 0;
  for (const int row : kRows) {
    const Angles a = angles_of(view, choice, row);
    for (int c = 0; c < kSide; c += kColumnStride) {
      const auto i = static_cast<std::size_t>(c);
      const double error = turn(a[0][i], a[1][i], truth.pixel(c, row).value().direction);
      if (!(error <= cell.worst_error)) cell.worst_error = error;
    }
  }
  judge(cell);
  return cell;
}

StabilityCell inverse_cell(bool vectors) {
  StabilityCell cell = begun("inverse", vectors ? "vector" : "one by one", "px");
  const AngleSetup s = setup();
  const SampleView view = view_of(s);
  const FrameExtent extent = frame_extent(view, kSide, kSide);
  cell.bound = (kInverseMaxError_rad + kAngleMaxError_rad / std::sin(incidence_angle(view))) * extent.spread /
               extent.pixel_step_rad;
  const synth::TruthGeometry truth = truth_of(s);
  cell.worst_error = 0;
  for (const int row : kRows) {
    for (int c = 0; c < kSide; c += kColumnStride) {
      const synth::Vec3 d = truth.pixel(c, row).value().direction;
      const std::array<double, 3> v{static_cast<double>(d.x), static_cast<double>(d.y), static_cast<double>(d.z)};
      PixelPosition found = pixel_of_direction(view, {v[0], v[1], v[2]}).value();
      if (vectors) {
        pixels_of_directions(view, kSide, kSide, {std::span(&v[0], 1), std::span(&v[1], 1), std::span(&v[2], 1)},
                             {std::span(&found.column, 1), std::span(&found.row, 1)});
      }
      const double error = std::hypot(found.column - c, found.row - row);
      if (!(error <= cell.worst_error)) cell.worst_error = error;
    }
  }
  judge(cell);
  cell.reason.clear();
  return cell;
}

}  // namespace

std::vector<StabilityCell> large_angles() {
  std::vector<StabilityCell> out;
  for (const AngleMethod m : angle_methods()) out.push_back(angle_cell(m));
  return out;
}

std::vector<StabilityCell> large_inverse() { return {inverse_cell(true), inverse_cell(false)}; }

}  // namespace scatmap::tools
