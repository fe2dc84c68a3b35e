#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "calib/calibrate.h"
#include "calib/observability.h"
#include "scatmap/angles/pixel_plane.h"
#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "tools/chart/scene.h"
#include "tools/chart/stability.h"

namespace scatmap::tools {
namespace {

using calib::CalibrationResult;
using calib::Target;
using calib::TargetKind;
using calib::TargetList;

constexpr double kSigma_px = 0.05, kEncoder_deg = 0.0005;

struct Setting {
  bool direct;
  double stage_deg, arm_deg, tilt_deg;
};

using Plan = std::vector<Setting>;

Setting mirror(double stage_deg, double arm_offset_deg, double tilt_deg) {
  return {false, stage_deg, 2 * stage_deg + arm_offset_deg, tilt_deg};
}

Plan full_plan() {
  Plan out;
  for (const double stage : {10.0, 20.0, 30.0, 40.0, 50.0, 60.0}) {
    for (const double arm : {-1.0, 0.0, 1.0}) {
      for (const double tilt : {-0.5, 0.0, 0.5}) out.push_back(mirror(stage, arm, tilt));
    }
  }
  for (const double arm : {179.0, 179.6, 180.4, 181.0}) out.push_back({true, 0, arm, 0});
  return out;
}

// Stage angles over `span_deg` only: the smaller, the worse conditioned.
Plan narrow_plan(double span_deg) {
  Plan out;
  for (const double share : {-0.5, -0.25, 0.0, 0.25, 0.5}) {
    for (const double tilt : {-0.5, 0.0, 0.5})
      out.push_back(mirror(30 + share * span_deg, share * span_deg, tilt * span_deg));
  }
  return out;
}

Plan repeated(Setting s, int times) { return Plan(static_cast<std::size_t>(times), s); }

// A bench a little off, within the mechanical tolerances.
synth::Bench off_bench() {
  synth::Bench b;
  b.columns = 3296;
  b.rows = 2472;
  b.pitch_um = {5.5, 5.5};
  b.distance_mm = 329;
  b.offset_mm = {0.6, -0.4};
  b.rotation_deg = {0.3, -0.2, 0.4};
  b.stage_zero_deg = 0.05;
  b.arm_zero_deg = -0.04;
  b.axis_offset_mm = {0.1, -0.1};
  b.beam_offset_mm = {0.1, 0.08};
  b.sample_tilt_deg = 0.1;
  b.sample_height_mm = 0.05;
  b.arm_encoder_sigma_deg = b.stage_encoder_sigma_deg = kEncoder_deg;
  return b;
}

TargetList observed(const synth::Bench& bench, const Plan& plan, std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  TargetList list{"targets.csv", {""}, {}};
  double stage_error = 0, arm_error = 0;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const Setting& s = plan[i];
    const bool again = i > 0 && s.direct == plan[i - 1].direct && s.stage_deg == plan[i - 1].stage_deg &&
                       s.arm_deg == plan[i - 1].arm_deg && s.tilt_deg == plan[i - 1].tilt_deg;
    if (!again) {
      stage_error = kEncoder_deg * normal(rng);
      arm_error = kEncoder_deg * normal(rng);
    }
    const synth::TruthGeometry truth(bench, s.stage_deg + stage_error, s.arm_deg + arm_error, s.tilt_deg);
    const auto hit = s.direct ? truth.direct_hit() : truth.mirror_hit();
    if (!hit) continue;
    Target t;
    t.kind = s.direct ? TargetKind::kDirect : TargetKind::kSpecular;
    t.stage_rad = s.stage_deg * kRadPerDeg;
    t.arm_rad = s.arm_deg * kRadPerDeg;
    t.tilt_rad = s.tilt_deg * kRadPerDeg;
    t.column_px = static_cast<double>(hit->column_px) + kSigma_px * normal(rng);
    t.row_px = static_cast<double>(hit->row_px) + kSigma_px * normal(rng);
    t.sigma_px = kSigma_px;
    t.line = static_cast<int>(i) + 2;
    list.targets.push_back(t);
  }
  return list;
}

struct Regime {
  const char* name;
  Plan plan;
  std::function<void(TargetList&)> spoil = [](TargetList&) {};
  bool must_refuse = false;  // no numbers may come of it
};

std::vector<Regime> regimes() {
  Plan specular = full_plan();
  std::erase_if(specular, [](const Setting& s) { return s.direct; });
  Plan centre_row = full_plan();
  std::erase_if(centre_row, [](const Setting& s) { return s.tilt_deg != 0; });
  Plan one_arm;
  for (const double tilt : {-0.5, -0.25, 0.0, 0.25, 0.5}) one_arm.push_back(mirror(20, 0, tilt));
  const auto shuffled = [](TargetList& l) { std::shuffle(l.targets.begin(), l.targets.end(), std::mt19937_64(4)); };
  const auto in_metres = [](TargetList& l) {
    for (Target& t : l.targets) {
      t.column_px *= 1e-3;
      t.row_px *= 1e-3;
    }
  };
  const auto in_millidegrees = [](TargetList& l) {
    for (Target& t : l.targets) {
      t.stage_rad *= 1e-3;
      t.arm_rad *= 1e-3;
    }
  };
  const auto doubled = [](TargetList& l) {
    const auto copy = l.targets;
    for (const Target& t : copy) l.targets.push_back(t);
  };
  const auto contradictory = [](TargetList& l) {
    const auto copy = l.targets;
    for (Target t : copy) {
      t.column_px += 40;
      l.targets.push_back(t);
    }
  };
  const auto third_gross = [](TargetList& l) {
    for (std::size_t i = 0; i < l.targets.size(); i += 3) l.targets[i].column_px += 50 + 20 * static_cast<double>(i);
  };
  return {
      {"plain, 58 targets", full_plan()},
      {"one target", {mirror(20, 0, 0)}},
      {"two targets", {mirror(20, 0, 0), mirror(30, 0.5, 0)}},
      {"three targets", {mirror(20, 0, 0), mirror(30, 1, 0), mirror(40, -1, 0.5)}},
      {"one arm angle", one_arm},
      {"specular only", specular},
      {"all on the centre row", centre_row},
      {"one pose a hundred times", repeated(mirror(20, 0, 0), 100)},
      {"one direct beam only", {{true, 0, 180, 0}}},
      {"stage angles within 1 deg", narrow_plan(1)},
      {"stage angles within 0.01 deg", narrow_plan(0.01)},
      {"stage angles within 1e-4 deg", narrow_plan(1e-4)},
      {"stage angles within 1e-6 deg", narrow_plan(1e-6)},
      {"targets in another order", full_plan(), shuffled},
      {"every target twice", full_plan(), doubled},
      {"every target again 40 px off", full_plan(), contradictory, true},
      {"a third of the targets gross", full_plan(), third_gross},
      {"centroids in units off by 1000", full_plan(), in_metres, true},
      {"angles in units off by 1000", full_plan(), in_millidegrees, true},
  };
}

struct Method {
  const char* name;
  calib::CalibrateOptions options;
};

std::vector<Method> methods() {
  calib::CalibrateOptions all;
  all.select = false;
  return {{"smallest set", {}}, {"all parameters", all}};
}

// By how much the pixel that sees a direction is mistaken, over its standard uncertainty; the larger axis.
double direction_error(const CalibrationResult& r, const synth::Bench& bench, const calib::DirectionSigma& d) {
  const synth::TruthGeometry truth(bench, d.point.pose.stage_rad * kDegPerRad, d.point.pose.arm_rad * kDegPerRad);
  const auto pixel = truth.pixel(d.point.column_px, d.point.row_px);
  if (!pixel) return NAN;
  const Vector3<double> direction(static_cast<double>(pixel->direction.x), static_cast<double>(pixel->direction.y),
                                  static_cast<double>(pixel->direction.z));
  const auto seen = pixel_of_direction(sample_view(r.instrument, d.point.pose), direction);
  if (!seen) return HUGE_VAL;
  return std::max(std::abs(seen->column - d.point.column_px) / d.column_px,
                  std::abs(seen->row - d.point.row_px) / d.row_px);
}

Instrument nominal() {
  synth::Bench b;
  b.columns = 3296;
  b.rows = 2472;
  b.pitch_um = {5.5, 5.5};
  b.distance_mm = 325;
  Instrument in = instrument_of(b);
  in.arm_encoder_sigma_rad = in.stage_encoder_sigma_rad = kEncoder_deg * kRadPerDeg;
  return in;
}

StabilityCell cell_of(const Regime& regime, const Method& method) {
  constexpr double kBound = 4;  // standard uncertainties; an honest one of thirty directions passes it once in 500 runs
  StabilityCell cell;
  cell.job = "calibrate";
  cell.regime = regime.name;
  cell.method = method.name;
  cell.unit = "sigma";
  cell.bound = kBound;
  std::mt19937_64 rng(6);
  TargetList list = observed(off_bench(), regime.plan, rng);
  regime.spoil(list);
  try {
    const CalibrationResult r = calib::calibrate(list, nominal(), method.options);
    cell.worst_error = 0;
    for (const calib::DirectionSigma& d : r.directions) {
      const double z = direction_error(r, off_bench(), d);
      if (!(z <= cell.worst_error)) cell.worst_error = z;
    }
    if (cell.worst_error <= kBound && !regime.must_refuse) cell.verdict = Verdict::kHolds;
    if (!r.observability.blind.empty())
      cell.reason = "says that it is blind to " + std::to_string(r.observability.blind.size()) + " combinations; ";
    cell.reason += "amplification: none, the error is counted in what the inputs' own sigmas make of it";
  } catch (const Error& e) {
    cell.reason = e.what();
    cell.verdict = regime.must_refuse ? Verdict::kRefuses : Verdict::kFails;
  }
  return cell;
}

}  // namespace

std::vector<StabilityCell> stability_calibrate() {
  std::vector<StabilityCell> out;
  for (const Regime& regime : regimes()) {
    for (const Method& method : methods()) out.push_back(cell_of(regime, method));
  }
  return out;
}

}  // namespace scatmap::tools
