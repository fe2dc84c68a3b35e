#include "tools/chart/target_bench.h"

#include <cmath>
#include <optional>

#include "scatmap/angles/pixel_plane.h"
#include "scatmap/base/units.h"
#include "tools/chart/scene.h"

namespace scatmap::tools {
namespace {

using calib::Target;
using calib::TargetKind;

constexpr double kSigma_px = 0.05, kEncoder_deg = 0.0005;

synth::Bench nominal_bench() {
  synth::Bench b;
  b.columns = 3296;
  b.rows = 2472;
  b.pitch_um = {5.5, 5.5};
  b.distance_mm = 325;
  b.arm_encoder_sigma_deg = b.stage_encoder_sigma_deg = kEncoder_deg;
  return b;
}

synth::Bench drawn_bench(const calib::ParameterTable& table, std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  const auto drawn = [&](const char* name, double& value) {
    const calib::Parameter& p = table[table.find(name).value()];
    value = (p.nominal + p.prior_sigma * normal(rng)) / p.unit;
  };
  synth::Bench b = nominal_bench();
  drawn("detector.distance_mm", b.distance_mm);
  drawn("detector.offset_mm.0", b.offset_mm[0]);
  drawn("detector.offset_mm.1", b.offset_mm[1]);
  drawn("detector.rotation_deg.0", b.rotation_deg[0]);
  drawn("detector.rotation_deg.1", b.rotation_deg[1]);
  drawn("detector.rotation_deg.2", b.rotation_deg[2]);
  drawn("arm.zero_deg", b.arm_zero_deg);
  drawn("arm.axis_offset_mm.0", b.axis_offset_mm[0]);
  drawn("arm.axis_offset_mm.1", b.axis_offset_mm[1]);
  drawn("arm.axis_tilt_deg.0", b.axis_tilt_deg[0]);
  drawn("arm.axis_tilt_deg.1", b.axis_tilt_deg[1]);
  drawn("beam.offset_mm.0", b.beam_offset_mm[0]);
  drawn("beam.offset_mm.1", b.beam_offset_mm[1]);
  drawn("beam.elevation_deg", b.beam_elevation_deg);
  drawn("sample.tilt_deg", b.sample_tilt_deg);
  drawn("sample.height_mm", b.sample_height_mm);
  b.stage_zero_deg = kStageZeroSigma_deg * normal(rng);
  return b;
}

// A target at random; nothing if its beam misses the detector.
std::optional<Target> shot(const synth::Bench& bench, bool direct, std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  const auto within = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng); };
  const double stage_deg = direct ? 0 : within(10, 60), arm_deg = (direct ? 180 : 2 * stage_deg) + within(-1, 1);
  const double tilt_deg = direct ? 0 : within(-0.5, 0.5);
  const synth::TruthGeometry truth(bench, stage_deg + kEncoder_deg * normal(rng), arm_deg + kEncoder_deg * normal(rng),
                                   tilt_deg);
  const auto hit = direct ? truth.direct_hit() : truth.mirror_hit();
  if (!hit) return std::nullopt;
  Target t;
  t.kind = direct ? TargetKind::kDirect : TargetKind::kSpecular;
  t.stage_rad = stage_deg * kRadPerDeg;
  t.arm_rad = arm_deg * kRadPerDeg;
  t.tilt_rad = tilt_deg * kRadPerDeg;
  t.column_px = static_cast<double>(hit->column_px) + kSigma_px * normal(rng);
  t.row_px = static_cast<double>(hit->row_px) + kSigma_px * normal(rng);
  t.sigma_px = kSigma_px;
  return t;
}

}  // namespace

TargetSession draw_session(std::size_t targets, std::mt19937_64& rng) {
  TargetSession out{{}, instrument_of(nominal_bench()), {"targets.csv", {""}, {}}};
  out.nominal.arm_encoder_sigma_rad = out.nominal.stage_encoder_sigma_rad = kEncoder_deg * kRadPerDeg;
  out.truth = drawn_bench(calib::ParameterTable(out.nominal, out.list, {}), rng);
  for (std::size_t i = 0; out.list.targets.size() < targets; ++i) {
    if (const auto t = shot(out.truth, i % 10 == 9, rng)) out.list.targets.push_back(*t);
  }
  return out;
}

Eigen::Vector2d direction_error_px(const TargetSession& session, const Instrument& instrument,
                                   const calib::DirectionPoint& point) {
  const Eigen::Vector2d nowhere = Eigen::Vector2d::Constant(std::nan(""));
  const synth::TruthGeometry truth(session.truth, point.pose.stage_rad * kDegPerRad, point.pose.arm_rad * kDegPerRad);
  const auto pixel = truth.pixel(point.column_px, point.row_px);
  if (!pixel) return nowhere;
  const Vector3<double> direction(static_cast<double>(pixel->direction.x), static_cast<double>(pixel->direction.y),
                                  static_cast<double>(pixel->direction.z));
  const auto seen = pixel_of_direction(sample_view(instrument, point.pose), direction);
  return seen ? Eigen::Vector2d(seen->column - point.column_px, seen->row - point.row_px) : nowhere;
}

}  // namespace scatmap::tools
