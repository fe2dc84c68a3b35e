#include "scatmap/angles/geometry.h"

#include "scatmap/base/units.h"

namespace scatmap {

const std::array<GeometryKey, kGeometryKeyCount>& geometry_keys() {
  using G = Geometry<double>;
  static constexpr std::array<GeometryKey, kGeometryKeyCount> kKeys{{
      {"detector.distance_mm", kMetrePerMm, &G::distance},
      {"detector.offset_mm.0", kMetrePerMm, &G::offset_x},
      {"detector.offset_mm.1", kMetrePerMm, &G::offset_y},
      {"detector.rotation_deg.0", kRadPerDeg, &G::rotation_pitch},
      {"detector.rotation_deg.1", kRadPerDeg, &G::rotation_yaw},
      {"detector.rotation_deg.2", kRadPerDeg, &G::rotation_roll},
      {"detector.pitch_um.0", kMetrePerUm, &G::pixel_column},
      {"detector.pitch_um.1", kMetrePerUm, &G::pixel_row},
      {"arm.zero_deg", kRadPerDeg, &G::arm_zero},
      {"arm.axis_offset_mm.0", kMetrePerMm, &G::arm_axis_x},
      {"arm.axis_offset_mm.1", kMetrePerMm, &G::arm_axis_z},
      {"arm.axis_tilt_deg.0", kRadPerDeg, &G::arm_axis_tilt_x},
      {"arm.axis_tilt_deg.1", kRadPerDeg, &G::arm_axis_tilt_z},
      {"stage.zero_deg", kRadPerDeg, &G::stage_zero},
      {"beam.offset_mm.0", kMetrePerMm, &G::beam_offset_x},
      {"beam.offset_mm.1", kMetrePerMm, &G::beam_offset_y},
      {"beam.elevation_deg", kRadPerDeg, &G::beam_elevation},
      {"sample.tilt_deg", kRadPerDeg, &G::sample_tilt},
      {"sample.height_mm", kMetrePerMm, &G::sample_height},
  }};
  return kKeys;
}

}  // namespace scatmap
