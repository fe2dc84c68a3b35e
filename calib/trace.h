#pragma once
#include <Eigen/Core>
#include <optional>

#include "calib/targets.h"
#include "scatmap/angles/instrument.h"
#include "scatmap/base/direction.h"

namespace scatmap::calib {

/// Where a beam meets the detector plane, and how that place moves.
struct Trace {
  Eigen::Vector2d pixel;  ///< column, row; may lie off the array
  /// px per metre or radian of each parameter, columns in the order of geometry_keys(). The columns of arm.zero_deg and
  /// stage.zero_deg are also the derivatives with respect to the motors' own angles.
  Eigen::Matrix<double, 2, static_cast<int>(kGeometryKeyCount)> jacobian;
};

inline constexpr Eigen::Index kArmZeroColumn = 8;
inline constexpr Eigen::Index kStageZeroColumn = 13;
inline constexpr Eigen::Index kTiltColumn = 17;
inline constexpr Eigen::Index kHeightColumn = 18;

/// How one target was shot. `tilt_rad` is the whole out-of-plane tilt, mount and setting together.
struct Shot {
  TargetKind kind = TargetKind::kSpecular;
  double stage_rad = 0;
  double arm_rad = 0;
  double tilt_rad = 0;
  double height_m = 0;
};

/// Beam line, mirrored at the plane n·X = h or not, onto the detector plane (design, section 1), with analytic
/// derivatives. What does not depend on the motors is worked out once.
class Tracer {
 public:
  /// @param geometry its sample_tilt and sample_height are not used: they come with each shot
  /// @param array    columns, rows and flips are used
  Tracer(const Geometry<double>& geometry, const Instrument& array);

  /// Nothing when the mirror is lit from behind or the beam never meets the front of the detector.
  std::optional<Trace> trace(const Shot& shot) const;

 private:
  struct Line;
  struct Hit;
  using Displacements = Eigen::Matrix<double, 3, static_cast<int>(kGeometryKeyCount)>;
  std::optional<Line> line_of(const Shot& shot) const;
  Displacements displacements(const Shot& shot, const Line& line, const Hit& hit) const;

  double arm_zero_, stage_zero_;
  Matrix3<double> axis_, mount_;                  // lab from arm axis, arm from detector
  Vector3<double> pitch_axis_, yaw_axis_;         // arm axes
  Vector3<double> tilt_z_axis_;                   // lab axes
  Vector3<double> axis_offset_, mount_offset_;    // lab axes, arm axes
  Vector3<double> beam_point_, along_, d_along_;  // lab axes; along = −b, and its change with the elevation
  Eigen::Vector2d per_pixel_, middle_, pitch_;    // flip / pitch; array centre, px; m
};

}  // namespace scatmap::calib
