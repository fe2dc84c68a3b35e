#include "tests/accuracy/angle_errors.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "scatmap/angles/angle_method.h"
#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/frame_extent.h"
#include "scatmap/base/error.h"
#include "tests/accuracy/regimes.h"

namespace scatmap::test {
namespace {

using Wide = long double;
constexpr Wide kPi = std::numbers::pi_v<long double>;

struct Truth {
  Wide theta, phi, sin_theta, cos_theta, solid_angle, step_rad;
};

// The pixel in long double by other formulae than the product's: half angles, which have no bad place.
Truth truth_of(const SampleView& v, int column, int row) {
  Wide p[3];
  for (int k = 0; k < 3; ++k) p[k] = v.origin[k] + Wide(column) * v.column_step[k] + Wide(row) * v.row_step[k];
  const Wide rho = std::hypot(p[0], p[1]), r = std::hypot(rho, p[2]);
  Truth t;
  t.theta = 2 * std::atan2(rho, r + p[2]);
  const Wide half = p[0] >= 0 ? std::atan2(p[1], rho + p[0]) : std::atan2(rho - p[0], p[1]);
  const Wide from_x = rho > 0 ? 2 * half : 0;
  t.phi = (from_x > kPi ? from_x - 2 * kPi : from_x) + kPi;
  t.sin_theta = rho / r;
  t.cos_theta = p[2] / r;
  const Wide facing = Wide(v.detector_normal.x()) * v.origin.x() + Wide(v.detector_normal.y()) * v.origin.y() +
                      Wide(v.detector_normal.z()) * v.origin.z();
  t.solid_angle = v.pixel_area_m2 * facing / (r * r * r);
  t.step_rad = std::min(v.column_step.norm(), v.row_step.norm()) * facing / (r * r);
  return t;
}

Wide direction_error(Wide theta, Wide phi, Wide theta_ref, Wide phi_ref, Wide sin_theta) {
  return std::hypot(theta - theta_ref, sin_theta * std::remainder(phi - phi_ref, 2 * kPi));
}

// NaN is worse than anything.
void raise(Wide& worst, Wide value) {
  if (!(value <= worst)) worst = value;
}

template <class T>
void add_frame(const SampleView& view, const AngleChoice& choice, const std::vector<std::pair<int, int>>& pixels,
               AngleMapOf<T>& map, WorstOfMethod& worst) {
  write_angle_map(view, choice, map);
  for (const auto& [column, row] : pixels) {
    const bool expected = pixel_angles(view, column, row).mask == 0;
    const T theta = map.theta_s_rad(row, column), phi = map.phi_s_rad(row, column);
    const bool numbers = !std::isnan(theta) && !std::isnan(phi);
    worst.wrong_pixels += expected != numbers || expected != (map.mask(row, column) == 0);
    if (numbers) worst.wrong_pixels += !(phi >= 0 && phi < T(2 * kPi) && theta >= 0);
    if (!expected || !numbers) continue;
    const Truth t = truth_of(view, column, row);
    const Wide error = direction_error(theta, phi, t.theta, t.phi, t.sin_theta);
    raise(worst.error_rad, error);
    raise(worst.share_rad, error / choice.bound_rad);
    raise(worst.share_px, error / t.step_rad / choice.bound_px);
    ++worst.samples;
  }
}

template <class T>
void add_rows(const SampleView& view, int columns, int row, double spread, Wide& solid_angle, Wide& cosine) {
  std::vector<T> omega(static_cast<std::size_t>(columns)), c(omega.size()), projected(omega.size());
  AngleRow<T> out;
  out.solid_angle_sr = omega;
  out.cos_theta_s = c;
  out.projected_solid_angle_sr = projected;
  angle_row(view, row, {0, columns}, out);
  const double omega_bound = sizeof(T) == 8 ? kRowSolidAngleMaxError : kSingleSolidAngleMaxError,
               c_bound = sizeof(T) == 8 ? kRowCosineMaxError : kSingleCosineMaxError;
  for (int column = 0; column < columns; column += 7) {
    if (pixel_angles(view, column, row).mask != 0) continue;
    const Truth t = truth_of(view, column, row);
    const auto i = static_cast<std::size_t>(column);
    raise(solid_angle, std::abs(omega[i] / t.solid_angle - 1) / (omega_bound * spread));
    raise(cosine, std::abs(c[i] - t.cos_theta) / (c_bound * spread));
    raise(cosine, std::abs(projected[i] / t.solid_angle - t.cos_theta) / ((omega_bound + c_bound) * spread));
  }
}

void add_chain(const RandomBench& bench, const SampleView& view, const std::vector<std::pair<int, int>>& pixels,
               double spread, Wide& share) {
  const synth::TruthGeometry truth(bench.truth, bench.stage_deg, bench.arm_deg);
  // At normal incidence the plane that phi is measured from is undefined.
  const Wide incidence = truth.incidence_rad(), plane = incidence > 1e-12L ? std::sin(incidence) : 1;
  for (const auto& [column, row] : pixels) {
    const auto t = truth.pixel(column, row);
    const PixelAngles a = pixel_angles(view, column, row);
    if (!t || a.mask != 0) continue;
    const Wide error =
        direction_error(a.theta_s_rad, a.phi_s_rad, t->theta_s_rad, t->phi_s_rad, std::sin(t->theta_s_rad));
    raise(share, error * plane / (kAngleMaxError_rad * spread));
  }
}

std::optional<SampleView> view_of(const RandomBench& bench) try {
  if (!(synth::TruthGeometry(bench.truth, bench.stage_deg, bench.arm_deg).incidence_rad() < 89 * kRadPerDeg))
    return std::nullopt;
  return sample_view(bench.instrument, bench.pose());
} catch (const Error&) {
  return std::nullopt;  // refused: beam or detector edge-on
}

}  // namespace

AngleErrors angle_errors(std::size_t regime, int frames, int samples, unsigned seed) {
  RegimeBenches benches(seed + static_cast<unsigned>(regime));
  AngleErrors out;
  for (int f = 0; f < frames; ++f) {
    const RandomBench bench = benches.draw(regime);
    const auto view = view_of(bench);
    const double tolerance_px = std::pow(10, benches.within(-4, 1));
    const int columns = bench.truth.columns, rows = bench.truth.rows;
    if (!view) continue;
    std::vector<std::pair<int, int>> pixels;
    for (int k = 0; k < samples; ++k) {
      const int column = static_cast<int>(benches.within(0, columns)), row = static_cast<int>(benches.within(0, rows));
      const bool corner = regime == 8 || k < 4;
      pixels.emplace_back(corner && k < 8 ? (k % 2) * (columns - 1) : column,
                          corner && k < 8 ? (k / 2 % 2) * (rows - 1) : row);
    }
    AngleMap wide{0, {rows, columns}, {rows, columns}, {}, {rows, columns}};
    AngleMapOf<float> narrow{0, {rows, columns}, {rows, columns}, {}, {rows, columns}};
    for (const AngleMethod method : angle_methods()) {
      const AngleChoice choice = with_method(method, *view, rows, columns, tolerance_px);
      WorstOfMethod& worst = out.methods[std::string(to_string(method))];
      if (!std::isfinite(choice.bound_rad))
        ++worst.frames_unbounded;
      else if (fills_single(method))
        add_frame(*view, choice, pixels, narrow, worst);
      else
        add_frame(*view, choice, pixels, wide, worst);
    }
    const double spread = frame_extent(*view, rows, columns).spread;
    add_rows<double>(*view, columns, rows / 2, spread, out.solid_angle_share, out.cosine_share);
    add_rows<float>(*view, columns, rows / 2, spread, out.single_solid_angle_share, out.single_cosine_share);
    add_chain(bench, *view, pixels, spread, out.chain_share);
  }
  return out;
}

}  // namespace scatmap::test
