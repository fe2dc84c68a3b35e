#pragma once
#include <cstdint>

#include "scatmap/angles/pixel_plane.h"
#include "scatmap/base/mask.h"
#include "scatmap/counts/row_kernels.h"

/// The vector loops of fused.cpp, one row at a time. Rows of `value` and `good` have kRowMargin readable zeros on
/// either side.
namespace scatmap {

inline constexpr int kWindowReach = 2;
inline constexpr int kWindowRows = 2 * kWindowReach + 1;
inline constexpr int kRowMargin = 8;  ///< the window's reach and more: column 0 then starts a cache line

/// A row of counts on the map's scale, before the geometry.
struct CleanRow {
  double* value;
  const float* floor;  ///< variance at zero signal
  const float* shot;   ///< variance per unit of signal
};

/// Sets the value of pixels that are not good to 0. @param good 1: mask 0, value and variances finite. @return whether
/// any pixel of mask 0 is not good
bool clean_row(const Mask* mask, int pixels, const CleanRow& row, std::uint8_t* good);

/// Rows of a 5 × 5 window; [kWindowReach] is the row in hand. Rows off the frame are zeros.
struct WindowRows {
  const double* value[kWindowRows];
  const std::uint8_t* good[kWindowRows];
};

/// expected_signal() along a row; NaN where the pixel is not good.
void expected_row(const WindowRows& rows, const float* floor, const float* shot, int pixels, double* expected);

/// Rays along one row of a flat detector.
struct GeometryRow {
  double x, y, z;                 ///< vector from the spot to the row's first pixel, m
  double x_step, y_step, z_step;  ///< per column
  double facing, facing_step;     ///< along the detector's normal
  double area_m2;
};
GeometryRow geometry_row(const SampleView& view, int row);

/// 1/(Ω cos theta_s) = |D|⁴/(area (nd·D)(n·D)) for columns [first, first + pixels) of a row: no angle and no root is
/// needed, and no division where n·D changes little over a strip.
void inverse_projected(const GeometryRow& g, int first, int pixels, double* out);

/// Where a strip of the map goes.
struct BrdfStrip {
  double* brdf_per_sr;
  float* u_random_per_sr;
  double* expected_per_sr;  ///< NaN where the map is
};

/// Divides by Ω cos theta_s; NaN where not good. @return whether any pixel may have given an infinite value
/// @param expected NaN where not good
bool brdf_strip(const CleanRow& in, const double* expected, const double* inverse_projected, int pixels,
                const BrdfStrip& out);

}  // namespace scatmap
