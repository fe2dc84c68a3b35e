#pragma once
#include <array>

namespace scatmap {

/// Every continuous geometric parameter of the instrument, inside units (metres, radians). Templated on the scalar so
/// that the product (double), references (long double) and calibration (automatic differentiation) share one text.
/// Axes and signs: docs/conventions.md; the numbers' file keys stand in kGeometryKeys.
template <class T>
struct Geometry {
  T distance{};  ///< detector plane to arm axis along the boresight
  T offset_x{};  ///< detector centre from the boresight, arm axes
  T offset_y{};
  T rotation_pitch{};  ///< about arm x
  T rotation_yaw{};    ///< about arm y
  T rotation_roll{};   ///< about arm z
  T pixel_column{};    ///< pixel pitch along a row of pixels (column to column)
  T pixel_row{};       ///< pixel pitch row to row
  T arm_zero{};        ///< added to the commanded arm angle
  T arm_axis_x{};      ///< arm axis from stage axis
  T arm_axis_z{};
  T arm_axis_tilt_x{};
  T arm_axis_tilt_z{};
  T stage_zero{};     ///< added to the commanded stage angle
  T beam_offset_x{};  ///< beam line passes through (x, y, 0)
  T beam_offset_y{};
  T beam_elevation{};
  T sample_tilt{};    ///< out-of-plane wedge of the sample normal
  T sample_height{};  ///< surface: n·X = height
};

/// One continuous parameter: its dotted name in instrument files and covariances, the metres or radians of one file
/// unit, and where it lives.
struct GeometryKey {
  const char* name;
  double unit;
  double Geometry<double>::*member;
};

inline constexpr std::size_t kGeometryKeyCount = 19;
/// All of them, in the order of the struct. Arrays are indexed: "detector.offset_mm.0".
const std::array<GeometryKey, kGeometryKeyCount>& geometry_keys();

}  // namespace scatmap
