#pragma once
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "calib/trace.h"
#include "data-synthetic/truth_geometry.h"
#include "scatmap/angles/pixel_plane.h"
#include "support/random_instrument.h"

/// Calibration runs made with the simulator's own truth, never with the forward model under test.
namespace scatmap::calib::test {

struct Mount {
  std::string name;
  double tilt_deg = 0;
  double height_mm = 0;
};

/// A target as commanded.
struct Command {
  bool direct = false;
  std::size_t mount = 0;
  double stage_deg = 0;
  double arm_deg = 0;
  double tilt_deg = 0;
};

struct Lab {
  synth::Bench bench;
  std::vector<Mount> mounts{{"", 0, 0}};
  std::vector<Command> commands;
  double sigma_px = 0.05;
};

inline synth::Bench plain_bench() {
  synth::Bench b;
  b.columns = 3296;
  b.rows = 2472;
  b.pitch_um = {5.5, 5.5};
  b.distance_mm = 325;
  return b;
}

inline Command mirror(double stage_deg, double arm_offset_deg = 0, double tilt_deg = 0, std::size_t mount = 0) {
  return {false, mount, stage_deg, 2 * stage_deg + arm_offset_deg, tilt_deg};
}
inline Command beam(double arm_deg) { return {true, 0, 0, arm_deg, 0}; }

/// Mirror settings over the whole range of angles, and six direct beams.
inline std::vector<Command> full_plan(std::size_t mounts = 1) {
  std::vector<Command> out;
  for (std::size_t m = 0; m < mounts; ++m) {
    for (const double stage : {10.0, 20.0, 30.0, 40.0, 50.0, 60.0}) {
      for (const double arm : {-1.0, 0.0, 1.0}) {
        for (const double tilt : {-0.5, 0.0, 0.5}) out.push_back(mirror(stage + static_cast<double>(m), arm, tilt, m));
      }
    }
  }
  for (const double arm : {179.0, 179.4, 179.8, 180.2, 180.6, 181.0}) out.push_back(beam(arm));
  return out;
}

/// `count` settings at random over the same range, one in ten a direct beam.
inline std::vector<Command> random_plan(std::size_t count, std::mt19937_64& rng) {
  const auto within = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng); };
  std::vector<Command> out;
  for (std::size_t i = 0; i < count; ++i) {
    out.push_back(i % 10 == 9 ? beam(180 + within(-1, 1)) : mirror(within(10, 60), within(-1, 1), within(-0.5, 0.5)));
  }
  return out;
}

inline synth::TruthGeometry truth_at(const Lab& lab, const Command& c, double stage_error_deg = 0,
                                     double arm_error_deg = 0) {
  synth::Bench b = lab.bench;
  if (!c.direct) {
    b.sample_tilt_deg = lab.mounts[c.mount].tilt_deg;
    b.sample_height_mm = lab.mounts[c.mount].height_mm;
  }
  return synth::TruthGeometry(b, static_cast<long double>(c.stage_deg) + stage_error_deg,
                              static_cast<long double>(c.arm_deg) + arm_error_deg, c.tilt_deg);
}

/// What the lab writes down. `normal` draws standard normal numbers: centroids get sigma_px, each setting the bench's
/// encoder sigmas; commands that repeat the one before keep its encoder errors.
template <class Normal>
TargetList written_down(const Lab& lab, Normal normal) {
  TargetList list{"targets.csv", {}, {}};
  for (const Mount& m : lab.mounts) list.mounts.push_back(m.name);
  double stage_error = 0, arm_error = 0;
  for (std::size_t i = 0; i < lab.commands.size(); ++i) {
    const Command& c = lab.commands[i];
    const bool again = i > 0 && c.direct == lab.commands[i - 1].direct && c.mount == lab.commands[i - 1].mount &&
                       c.stage_deg == lab.commands[i - 1].stage_deg && c.arm_deg == lab.commands[i - 1].arm_deg &&
                       c.tilt_deg == lab.commands[i - 1].tilt_deg;
    if (!again) {
      stage_error = lab.bench.stage_encoder_sigma_deg * normal();
      arm_error = lab.bench.arm_encoder_sigma_deg * normal();
    }
    const synth::TruthGeometry truth = truth_at(lab, c, stage_error, arm_error);
    const auto hit = c.direct ? truth.direct_hit() : truth.mirror_hit();
    if (!hit) throw std::logic_error("a command of the test misses the detector");
    Target t{c.direct ? TargetKind::kDirect : TargetKind::kSpecular,
             c.stage_deg * kRadPerDeg,
             c.arm_deg * kRadPerDeg,
             c.tilt_deg * kRadPerDeg,
             static_cast<double>(hit->column_px),
             static_cast<double>(hit->row_px),
             lab.sigma_px,
             c.mount,
             "",
             static_cast<int>(i) + 2};
    t.column_px += lab.sigma_px * normal();
    t.row_px += lab.sigma_px * normal();
    list.targets.push_back(t);
  }
  return list;
}

inline TargetList observe_exactly(const Lab& lab) {
  return written_down(lab, [] { return 0.0; });
}

inline TargetList observe(const Lab& lab, std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  return written_down(lab, [&] { return normal(rng); });
}

/// The truth in the order of a ParameterTable, file units.
inline std::vector<double> true_values(const Lab& lab) {
  const synth::Bench& b = lab.bench;
  std::vector<double> out{b.distance_mm,       b.offset_mm[0],      b.offset_mm[1],      b.rotation_deg[0],
                          b.rotation_deg[1],   b.rotation_deg[2],   b.pitch_um[0],       b.pitch_um[1],
                          b.arm_zero_deg,      b.axis_offset_mm[0], b.axis_offset_mm[1], b.axis_tilt_deg[0],
                          b.axis_tilt_deg[1],  b.stage_zero_deg,    b.beam_offset_mm[0], b.beam_offset_mm[1],
                          b.beam_elevation_deg};
  for (const Mount& m : lab.mounts) {
    out.push_back(m.tilt_deg);
    out.push_back(m.height_mm);
  }
  return out;
}

/// The truth as the lab believes it: the bench without its mirror mounts.
inline Instrument believed(const synth::Bench& bench) {
  Instrument in = scatmap::test::instrument_of(bench);
  in.arm_encoder_sigma_rad = bench.arm_encoder_sigma_deg * kRadPerDeg;
  in.stage_encoder_sigma_rad = bench.stage_encoder_sigma_deg * kRadPerDeg;
  return in;
}

/// Calibrated direction of a pixel less the true one, in pixels along columns and rows.
inline Eigen::Vector2d direction_error_px(const Lab& lab, const Instrument& calibrated, const DirectionPoint& at,
                                          std::size_t mount = 0) {
  const SampleView view = sample_view(calibrated, at.pose);
  const Command c{false, mount, at.pose.stage_rad * kDegPerRad, at.pose.arm_rad * kDegPerRad, 0};
  const auto truth = truth_at(lab, c).pixel(at.column_px, at.row_px);
  if (!truth) throw std::logic_error("a reference pixel of the test does not see the sample");
  const Vector3<double> v(static_cast<double>(truth->direction.x), static_cast<double>(truth->direction.y),
                          static_cast<double>(truth->direction.z));
  // Where the true ray meets the calibrated detector plane, in pixels from the pixel that sent it.
  const auto hit = pixel_of_direction(view, v);
  if (!hit) return Eigen::Vector2d::Constant(std::nan(""));
  return {hit->column - at.column_px, hit->row - at.row_px};
}

}  // namespace scatmap::calib::test
