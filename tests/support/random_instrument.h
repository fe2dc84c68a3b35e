#pragma once
#include <random>

#include "data-synthetic/truth_geometry.h"
#include "scatmap/angles/instrument.h"
#include "scatmap/base/units.h"

/// Benches with every parameter non-zero, in the words of the simulator's own truth and of the product.
namespace scatmap::test {

struct RandomBench {
  synth::Bench truth;
  Instrument instrument;
  double stage_deg = 0;
  double arm_deg = 0;
  Pose pose() const { return {stage_deg * kRadPerDeg, arm_deg * kRadPerDeg}; }
};

inline Instrument instrument_of(const synth::Bench& b) {
  Instrument in;
  in.columns = b.columns;
  in.rows = b.rows;
  in.flip_columns = b.flip_columns;
  in.flip_rows = b.flip_rows;
  Geometry<double>& g = in.geometry;
  g.distance = b.distance_mm * 1e-3;
  g.offset_x = b.offset_mm[0] * 1e-3;
  g.offset_y = b.offset_mm[1] * 1e-3;
  g.rotation_pitch = b.rotation_deg[0] * kRadPerDeg;
  g.rotation_yaw = b.rotation_deg[1] * kRadPerDeg;
  g.rotation_roll = b.rotation_deg[2] * kRadPerDeg;
  g.pixel_column = b.pitch_um[0] * 1e-6;
  g.pixel_row = b.pitch_um[1] * 1e-6;
  g.arm_zero = b.arm_zero_deg * kRadPerDeg;
  g.arm_axis_x = b.axis_offset_mm[0] * 1e-3;
  g.arm_axis_z = b.axis_offset_mm[1] * 1e-3;
  g.arm_axis_tilt_x = b.axis_tilt_deg[0] * kRadPerDeg;
  g.arm_axis_tilt_z = b.axis_tilt_deg[1] * kRadPerDeg;
  g.stage_zero = b.stage_zero_deg * kRadPerDeg;
  g.beam_offset_x = b.beam_offset_mm[0] * 1e-3;
  g.beam_offset_y = b.beam_offset_mm[1] * 1e-3;
  g.beam_elevation = b.beam_elevation_deg * kRadPerDeg;
  g.sample_tilt = b.sample_tilt_deg * kRadPerDeg;
  g.sample_height = b.sample_height_mm * 1e-3;
  return in;
}

/// @param spread 1: a plausible bench; larger: wilder rotations and offsets
inline RandomBench random_bench(std::mt19937_64& rng, double spread) {
  const auto within = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng); };
  RandomBench out;
  synth::Bench& b = out.truth;
  b.columns = 200 + static_cast<int>(within(0, 3000));
  b.rows = 200 + static_cast<int>(within(0, 2000));
  b.pitch_um = {within(2, 25), within(2, 25)};
  b.distance_mm = within(80, 900);
  b.offset_mm = {spread * within(-5, 5), spread * within(-5, 5)};
  b.rotation_deg = {spread * within(-3, 3), spread * within(-3, 3), spread * within(-10, 10)};
  b.flip_columns = within(0, 1) < 0.5;
  b.flip_rows = within(0, 1) < 0.5;
  b.arm_zero_deg = spread * within(-0.5, 0.5);
  b.axis_offset_mm = {within(-1, 1), within(-1, 1)};
  b.axis_tilt_deg = {spread * within(-0.5, 0.5), spread * within(-0.5, 0.5)};
  b.stage_zero_deg = spread * within(-0.5, 0.5);
  b.beam_elevation_deg = spread * within(-0.5, 0.5);
  b.beam_offset_mm = {within(-1, 1), within(-1, 1)};
  b.sample_tilt_deg = spread * within(-1, 1);
  b.sample_height_mm = within(-1, 1);
  out.stage_deg = within(-70, 70);
  out.arm_deg = 2 * out.stage_deg + within(-15, 15);
  out.instrument = instrument_of(b);
  return out;
}

}  // namespace scatmap::test
