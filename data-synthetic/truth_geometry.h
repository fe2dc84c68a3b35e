#pragma once
#include <array>
#include <optional>

#include "data-synthetic/vec3.h"

namespace scatmap::synth {

/// Every geometric parameter of the bench (design, section 1), in the units of the files: what is written is what was
/// read, bit for bit.
struct Bench {
  int columns = 0;
  int rows = 0;
  std::array<double, 2> pitch_um{};      ///< along columns, along rows
  double distance_mm = 0;                ///< R
  std::array<double, 2> offset_mm{};     ///< (ox, oy)
  std::array<double, 3> rotation_deg{};  ///< pitch, yaw, roll
  bool flip_columns = false;
  bool flip_rows = false;
  double arm_zero_deg = 0;
  std::array<double, 2> axis_offset_mm{};  ///< (ex, ez)
  std::array<double, 2> axis_tilt_deg{};   ///< (tx, tz)
  double arm_encoder_sigma_deg = 0;
  double stage_zero_deg = 0;
  double stage_encoder_sigma_deg = 0;
  double beam_elevation_deg = 0;
  std::array<double, 2> beam_offset_mm{};  ///< (bx, by)
  double sample_tilt_deg = 0;
  double sample_height_mm = 0;
};

struct PixelTruth {
  Vec3 direction;  ///< from the spot to the pixel, unit, sample axes
  long double theta_s_rad = 0;
  long double phi_s_rad = 0;  ///< [0, 2π), from −x
  long double solid_angle_sr = 0;
};

/// A place on the sensor; integers are pixel centres.
struct PixelPoint {
  long double column_px = 0;
  long double row_px = 0;
};

/// The bench with both motors standing still, in long double (64-bit significand): errors near 1e-18 relative.
class TruthGeometry {
 public:
  /// Motor angles are the true ones, encoder errors included; `extra_tilt_deg` adds to the sample's tilt.
  TruthGeometry(const Bench& bench, long double stage_deg, long double arm_deg, long double extra_tilt_deg = 0);

  /// Towards the light source, unit, sample axes.
  Vec3 to_source() const { return to_sample(to_source_); }
  /// θi, rad.
  long double incidence_rad() const;
  /// Spot on the sample, lab axes, m. Not finite when the beam runs along the surface.
  Vec3 spot_m() const { return spot_m_; }
  /// Centre of a pixel, lab axes, m.
  Vec3 pixel_m(long double column_px, long double row_px) const;
  /// Nothing when the sample is lit from behind, the pixel is below its horizon, or the light meets the back of the
  /// sensor.
  std::optional<PixelTruth> pixel(long double column_px, long double row_px) const;
  /// Where the beam meets the sensor plane with no sample in the way. Nothing when it never does, or from behind.
  std::optional<PixelPoint> direct_hit() const { return hit(beam_point_m_, beam_direction_); }
  /// The same for the beam reflected by a mirror in the sample's place.
  std::optional<PixelPoint> mirror_hit() const;

 private:
  Vec3 to_sample(const Vec3& lab) const { return {dot(lab, x_), dot(lab, y_), dot(lab, z_)}; }
  std::optional<PixelPoint> hit(const Vec3& point_m, const Vec3& direction) const;
  void place_sample(const Bench& bench, long double stage_deg, long double tilt_deg);
  void place_sensor(const Bench& bench, long double arm_deg);

  Vec3 to_source_, beam_direction_, beam_point_m_;  // lab axes
  Vec3 spot_m_, x_, y_, z_;                         // sample axes seen from the lab
  Vec3 centre_m_, along_columns_, along_rows_, sensor_normal_;
  long double column_step_m_ = 0, row_step_m_ = 0;  // signed by the flips
  long double middle_column_px_ = 0, middle_row_px_ = 0;
};

}  // namespace scatmap::synth
