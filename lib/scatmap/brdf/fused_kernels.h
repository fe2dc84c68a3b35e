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
inline constexpr int kRowMargin = 16;  ///< the window's reach and more: column 0 then starts a cache line

/// A row of counts, DN.
struct CleanRow {
  float* value;
  const float* floor;  ///< variance at zero signal
  const float* shot;   ///< variance per unit of signal
};

/// Sets the value of pixels that are not good to 0. @param good 1: mask 0, value and variances finite. @return whether
/// any pixel of mask 0 is not good
bool clean_row(const Mask* mask, int pixels, const CleanRow& row, std::uint8_t* good);

/// Rows of a 5 × 5 window; [kWindowReach] is the row in hand. Rows off the frame are zeros.
struct WindowRows {
  const float* value[kWindowRows];
  const std::uint8_t* good[kWindowRows];
};

/// Rays along one row of a flat detector.
struct GeometryRow {
  double x, y, z;                 ///< vector from the spot to the row's first pixel, m
  double x_step, y_step, z_step;  ///< per column
  double facing, facing_step;     ///< along the detector's normal
  double area_m2;
};
GeometryRow geometry_row(const SampleView& view, int row);

/// scale/(Ω cos theta_s) = scale |D|⁴/(area (nd·D)(n·D)) for columns [first, first + pixels) of a row: no angle and no
/// root is needed, and no division where it is close enough to a polynomial along the row (1e-8).
void inverse_projected(const GeometryRow& g, double scale, int first, int pixels, double* out);

/// Where a strip of the map goes.
struct BrdfStrip {
  float* brdf_per_sr;
  float* u_random_per_sr;
  double* expected_per_sr;  ///< NaN where the map is
};

/// expected_signal() along a strip, then the division by Ω cos theta_s; NaN where the pixel is not good.
/// @param floor, shot  CleanRow; @param per_dn  map units per DN; @param pixels at most kStrip. @return whether any
/// pixel may have given an infinite value
bool map_strip(const WindowRows& rows, const float* floor, const float* shot, const double* per_dn, int pixels,
               const BrdfStrip& out);

}  // namespace scatmap
