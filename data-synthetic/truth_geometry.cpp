#include "data-synthetic/truth_geometry.h"

#include <cmath>

namespace scatmap::synth {
namespace {

constexpr long double kMetrePerMillimetre = 1e-3L;
constexpr long double kMetrePerMicrometre = 1e-6L;
// Shorter than this, the beam's component along the surface is rounding, and the sample's x axis falls back.
constexpr long double kParallel = 1e-12L;

}  // namespace

TruthGeometry::TruthGeometry(const Bench& bench, long double stage_deg, long double arm_deg,
                             long double extra_tilt_deg) {
  // Elevation lifts the source towards +y, which is a turn about x by minus that angle.
  to_source_ = turn_x({0, 0, 1}, -static_cast<long double>(bench.beam_elevation_deg));
  beam_direction_ = -1 * to_source_;
  beam_point_m_ = kMetrePerMillimetre * Vec3{bench.beam_offset_mm[0], bench.beam_offset_mm[1], 0};
  place_sample(bench, stage_deg + bench.stage_zero_deg, bench.sample_tilt_deg + extra_tilt_deg);
  place_sensor(bench, arm_deg + bench.arm_zero_deg);
}

void TruthGeometry::place_sample(const Bench& bench, long double stage_deg, long double tilt_deg) {
  z_ = turn_y(turn_x({0, 0, 1}, tilt_deg), stage_deg);
  const Vec3 along = beam_direction_ - dot(beam_direction_, z_) * z_;
  // By way of y: near normal incidence `along` is a small difference and need not lie in the surface.
  y_ = unit(cross(z_, length(along) > kParallel ? along : turn_y({1, 0, 0}, stage_deg)));
  x_ = cross(y_, z_);
  const long double height_m = kMetrePerMillimetre * bench.sample_height_mm;
  const long double way_m = (height_m - dot(z_, beam_point_m_)) / dot(z_, beam_direction_);
  spot_m_ = beam_point_m_ + way_m * beam_direction_;
}

void TruthGeometry::place_sensor(const Bench& bench, long double arm_deg) {
  const auto on_arm = [&](const Vec3& v) {
    return turn_z(turn_y(turn_x(v, bench.rotation_deg[0]), bench.rotation_deg[1]), bench.rotation_deg[2]);
  };
  const auto in_lab = [&](const Vec3& v) {
    return turn_x(turn_z(turn_y(v, arm_deg), bench.axis_tilt_deg[1]), bench.axis_tilt_deg[0]);
  };
  const Vec3 axis_m = kMetrePerMillimetre * Vec3{bench.axis_offset_mm[0], 0, bench.axis_offset_mm[1]};
  const Vec3 mount_m = kMetrePerMillimetre * Vec3{bench.offset_mm[0], bench.offset_mm[1], bench.distance_mm};
  centre_m_ = axis_m + in_lab(mount_m);
  along_columns_ = in_lab(on_arm({1, 0, 0}));
  along_rows_ = in_lab(on_arm({0, 1, 0}));
  sensor_normal_ = in_lab(on_arm({0, 0, 1}));
  column_step_m_ = (bench.flip_columns ? -1 : 1) * kMetrePerMicrometre * bench.pitch_um[0];
  row_step_m_ = (bench.flip_rows ? -1 : 1) * kMetrePerMicrometre * bench.pitch_um[1];
  middle_column_px_ = (bench.columns - 1) / 2.0L;
  middle_row_px_ = (bench.rows - 1) / 2.0L;
}

long double TruthGeometry::incidence_rad() const {
  const Vec3 b = to_source();
  return std::atan2(std::hypot(b.x, b.y), b.z);
}

Vec3 TruthGeometry::pixel_m(long double column_px, long double row_px) const {
  return centre_m_ + (column_px - middle_column_px_) * column_step_m_ * along_columns_ +
         (row_px - middle_row_px_) * row_step_m_ * along_rows_;
}

std::optional<PixelTruth> TruthGeometry::pixel(long double column_px, long double row_px) const {
  const Vec3 from_spot_m = pixel_m(column_px, row_px) - spot_m_;
  const long double distance_m = length(from_spot_m);
  const long double facing_m = dot(sensor_normal_, from_spot_m);
  PixelTruth out;
  out.direction = (1 / distance_m) * to_sample(from_spot_m);
  const Vec3& v = out.direction;
  if (!(dot(z_, to_source_) > 0 && v.z > 0 && facing_m > 0)) return std::nullopt;
  out.theta_s_rad = std::atan2(std::hypot(v.x, v.y), v.z);
  out.phi_s_rad = std::atan2(v.y, v.x) + kPi;
  if (out.phi_s_rad >= 2 * kPi) out.phi_s_rad = 0;
  const long double area_m2 = std::fabs(column_step_m_ * row_step_m_);
  out.solid_angle_sr = area_m2 * facing_m / (distance_m * distance_m * distance_m);
  return out;
}

std::optional<PixelPoint> TruthGeometry::mirror_hit() const {
  const long double towards = dot(beam_direction_, z_);
  if (!(towards < 0)) return std::nullopt;
  return hit(spot_m_, beam_direction_ - 2 * towards * z_);
}

std::optional<PixelPoint> TruthGeometry::hit(const Vec3& point_m, const Vec3& direction) const {
  const long double closing = dot(direction, sensor_normal_);
  const long double way_m = dot(centre_m_ - point_m, sensor_normal_) / closing;
  if (!(closing > 0 && way_m > 0)) return std::nullopt;
  const Vec3 on_sensor_m = point_m + way_m * direction - centre_m_;
  return PixelPoint{middle_column_px_ + dot(on_sensor_m, along_columns_) / column_step_m_,
                    middle_row_px_ + dot(on_sensor_m, along_rows_) / row_step_m_};
}

}  // namespace scatmap::synth
