#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "scatmap/angles/angle_method.h"
#include "scatmap/angles/frame_extent.h"
#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "tools/chart/angle_regimes.h"
#include "tools/chart/scene.h"
#include "tools/chart/stability.h"
#include "tools/chart/stability_large.h"

namespace scatmap::tools {
namespace {

// Every parameter moved by `step(value, typical)`.
template <class Step>
AngleSetup moved(AngleSetup s, Step step) {
  synth::Bench& b = s.bench;
  constexpr double kAngle = 1e-3, kLength = 1e-2, kPitch = 1e-4;  // deg, mm, um: a plain bench's uncertainties
  for (double* v :
       {&s.stage_deg, &s.arm_deg, &b.rotation_deg[0], &b.rotation_deg[1], &b.rotation_deg[2], &b.arm_zero_deg,
        &b.axis_tilt_deg[0], &b.axis_tilt_deg[1], &b.stage_zero_deg, &b.beam_elevation_deg, &b.sample_tilt_deg})
    *v = step(*v, kAngle);
  for (double* v : {&b.distance_mm, &b.offset_mm[0], &b.offset_mm[1], &b.axis_offset_mm[0], &b.axis_offset_mm[1],
                    &b.beam_offset_mm[0], &b.beam_offset_mm[1], &b.sample_height_mm})
    *v = step(*v, std::min(kLength, 0.01 * b.distance_mm));
  for (double* v : {&b.pitch_um[0], &b.pitch_um[1]}) *v = step(*v, kPitch);
  return s;
}

using Direction = Eigen::Matrix<long double, 3, 1>;

Direction direction_of(double theta, double phi) {
  const long double azimuth = static_cast<long double>(phi) - std::numbers::pi_v<long double>;
  const long double t = theta;
  return {std::sin(t) * std::cos(azimuth), std::sin(t) * std::sin(azimuth), std::cos(t)};
}
Direction direction_of(const synth::Vec3& v) { return {v.x, v.y, v.z}; }

struct Angles {
  Grid<double> theta, phi;
  Grid<Mask> mask;
  double bound_rad = 0;
};

// At normal incidence phi has no zero: the truth itself is ill-conditioned.
constexpr double kLeastIncidence_rad = 1e-3;

struct Method {
  AngleMethod method;
  std::string name() const { return std::string(to_string(method)); }
};

std::vector<Method> methods() {
  std::vector<Method> out;
  for (const AngleMethod m : angle_methods()) out.push_back({m});
  return out;
}

Grid<double> widened(const Grid<float>& narrow) {
  Grid<double> out(narrow.rows(), narrow.columns());
  std::copy(narrow.begin(), narrow.end(), out.begin());
  return out;
}

Angles map_of(AngleMethod method, const Instrument& in, const Pose& pose) {
  constexpr double kTolerance_px = 0.01;
  const int rows = in.rows, columns = in.columns;
  const SampleView view = sample_view(in, pose);
  const AngleChoice choice = with_method(method, view, rows, columns, kTolerance_px);
  // From the numbers of the file to the view; the method's own bound is from there on.
  const FrameExtent extent = frame_extent(view, rows, columns);
  const double view_bound_rad =
      kAngleMaxError_rad * extent.spread / std::max(std::sin(incidence_angle(view)), kLeastIncidence_rad);
  const double bound_rad = choice.bound_rad + view_bound_rad;
  if (fills_single(method)) {
    AngleMapOf<float> map{0, {rows, columns}, {rows, columns}, {}, {rows, columns}};
    write_angle_map(view, choice, map);
    return {widened(map.theta_s_rad), widened(map.phi_s_rad), std::move(map.mask), bound_rad};
  }
  AngleMap map{0, {rows, columns}, {rows, columns}, {}, {rows, columns}};
  write_angle_map(view, choice, map);
  return {std::move(map.theta_s_rad), std::move(map.phi_s_rad), std::move(map.mask), bound_rad};
}

Angles evaluated(const Method& method, const AngleSetup& s) {
  return map_of(method.method, instrument_of(s.bench), {s.stage_deg * kRadPerDeg, s.arm_deg * kRadPerDeg});
}

// Largest turn of a direction, between a method's answer and the truth or between two truths.
struct Turn {
  double largest = 0;
  std::string failure;
};

// Rounding decides on which side of the horizon, or of the detector, a pixel within this of it lies.
constexpr double kUndecided = 1e-12;

bool undecided(const synth::TruthGeometry& truth, const AngleSetup& s, int column, int row) {
  AngleSetup nudged = s;
  for (const double nudge : {-kUndecided, kUndecided}) {
    nudged.bench.rotation_deg[1] = s.bench.rotation_deg[1] + nudge * 57;
    nudged.stage_deg = s.stage_deg + nudge * 57;
    if (truth_of(nudged).pixel(column, row).has_value() != truth.pixel(column, row).has_value()) return true;
  }
  return false;
}

Turn error_of(const Angles& a, const AngleSetup& s) {
  const synth::TruthGeometry truth = truth_of(s);
  Turn out;
  for (int row = 0; row < s.bench.rows; ++row) {
    for (int column = 0; column < s.bench.columns; ++column) {
      const auto pixel = truth.pixel(column, row);
      const bool given = a.mask(row, column) == 0;
      if (given != pixel.has_value()) {
        if (!undecided(truth, s, column, row)) out.failure = given ? "number where there is none" : "no number";
        continue;
      }
      if (!given) {
        if (!std::isnan(a.theta(row, column)) || !std::isnan(a.phi(row, column))) out.failure = "masked, but a number";
        continue;
      }
      const double turn = static_cast<double>(
          (direction_of(a.theta(row, column), a.phi(row, column)) - direction_of(pixel->direction)).norm());
      if (!(turn <= out.largest)) out.largest = turn;
      if (!(a.phi(row, column) >= 0 && a.phi(row, column) <= 2 * std::numbers::pi)) out.failure = "phi out of range";
    }
  }
  return out;
}

// Largest change of the answer, and of the truth, over pixels that both have.
std::pair<double, double> change(const Angles& a, const Angles& b, const AngleSetup& s, const AngleSetup& moved_setup) {
  const synth::TruthGeometry before = truth_of(s), after = truth_of(moved_setup);
  double answer = 0, truth = 0;
  for (int row = 0; row < s.bench.rows; ++row) {
    for (int column = 0; column < s.bench.columns; ++column) {
      const auto p = before.pixel(column, row), q = after.pixel(column, row);
      if (!p || !q || a.mask(row, column) != 0 || b.mask(row, column) != 0) continue;
      truth = std::max(truth, static_cast<double>((direction_of(p->direction) - direction_of(q->direction)).norm()));
      answer = std::max(answer, static_cast<double>((direction_of(a.theta(row, column), a.phi(row, column)) -
                                                     direction_of(b.theta(row, column), b.phi(row, column)))
                                                        .norm()));
    }
  }
  return {answer, truth};
}

StabilityCell cell_of(const AngleRegime& regime, const Method& method) {
  StabilityCell cell;
  cell.job = "angles";
  cell.regime = regime.name;
  cell.method = method.name();
  cell.unit = "rad";
  const AngleSetup& s = regime.setup;
  Angles answer;
  try {
    answer = evaluated(method, s);
  } catch (const Error& e) {
    cell.verdict = is_impossible(s) ? Verdict::kRefuses : Verdict::kFails;
    cell.reason = e.what();
    return cell;
  }
  cell.bound = answer.bound_rad;
  const Turn error = error_of(answer, s);
  cell.worst_error = error.largest;
  std::mt19937_64 rng(3);
  const AngleSetup by_ulp =
      moved(s, [&](double v, double) { return std::nextafter(v, rng() % 2 == 0 ? -HUGE_VAL : HUGE_VAL); });
  const AngleSetup by_sigma =
      moved(s, [&](double v, double typical) { return v + (rng() % 2 == 0 ? -typical : typical); });
  const auto [answer_ulp, truth_ulp] = change(answer, evaluated(method, by_ulp), s, by_ulp);
  const auto [answer_sigma, truth_sigma] = change(answer, evaluated(method, by_sigma), s, by_sigma);
  if (truth_ulp > 0) cell.amplification_ulp = answer_ulp / truth_ulp;
  if (truth_sigma > 0) cell.amplification_sigma = answer_sigma / truth_sigma;
  constexpr double kRoundingSteps = 20;  // inputs are rounded when read, converted and combined
  if (std::isinf(cell.bound)) {
    cell.verdict = Verdict::kRefuses;
    cell.reason = "states no bound here, so that no tolerance picks it";
  } else if (!error.failure.empty()) {
    cell.reason = error.failure;
  } else if (truth_ulp == 0 && error.largest == 0) {
    cell.verdict = Verdict::kRefuses;
    cell.reason = "every pixel masked";
  } else if (error.largest <= cell.bound) {
    cell.verdict = Verdict::kHolds;
  } else if (error.largest <= kRoundingSteps * truth_ulp) {
    cell.verdict = Verdict::kIllConditioned;
  }
  return cell;
}

}  // namespace

std::vector<StabilityCell> stability_angles() {
  std::vector<StabilityCell> out;
  for (const AngleRegime& regime : angle_regimes()) {
    for (const Method& method : methods()) out.push_back(cell_of(regime, method));
  }
  for (const StabilityCell& cell : large_angles()) out.push_back(cell);
  return out;
}

}  // namespace scatmap::tools
