#pragma once
#include <span>

#include "scatmap/angles/pixel_plane.h"
#include "scatmap/base/mask.h"

namespace scatmap {

/// Columns [first, last).
struct ColumnRange {
  int first = 0;
  int last = 0;
  int size() const { return last - first; }
};

/// Where the numbers of a part of one row go. Each span is empty (not wanted, not computed) or has one place for every
/// column asked for. theta and phi come together.
template <class T>
struct AngleRow {
  std::span<T> theta_s_rad{};
  std::span<T> phi_s_rad{};
  std::span<T> solid_angle_sr{};
  std::span<T> cos_theta_s{};
  std::span<T> projected_solid_angle_sr{};  ///< solid angle × cos(theta_s): what BRDF divides by
  std::span<Mask> mask{};
};

/// The `vector` method: as `exact`, a whole row in vector instructions. Pixels below the horizon or behind the detector
/// get NaN and their mask bit, the very same pixels in every method. Allocates nothing; columns may lie off the array.
/// Error against long double on the same view: kVectorMaxError_rad for theta and sin(theta)·phi,
/// kRowSolidAngleMaxError relative, kRowCosineMaxError absolute, and relative for the projected solid angle their sum
/// with cos(theta_s) in place of 1.
void angle_row(const SampleView& view, int row, ColumnRange columns, const AngleRow<double>& out);

/// The `single` method: the same in float32, from a reference direction per part of a row in extended precision, so
/// that little but the rounding of the results is lost. Error: kSingleMaxError_rad anywhere, single_bound_rad of one
/// frame; kSingleSolidAngleMaxError relative; kSingleCosineMaxError absolute.
void angle_row(const SampleView& view, int row, ColumnRange columns, const AngleRow<float>& out);

/// The part of `columns` whose pixels see the front of the sample and show it their own front; the rest of them carry
/// `mask` of pixel_angles. By the same sums as pixel_angles: no method differs on a single pixel.
ColumnRange visible_columns(const SampleView& view, int row, ColumnRange columns);

/// On frames whose farthest pixel is FrameExtent::spread times as far from the spot as the nearest, times spread.
inline constexpr double kVectorMaxError_rad = 6e-16;
inline constexpr double kVectorTruncation_rad = 2e-17;  ///< of that, what the tiles of whole maps leave out
inline constexpr double kRowSolidAngleMaxError = 2e-15;
inline constexpr double kRowCosineMaxError = 5e-16;
/// Rounding of theta (6e-8) and of phi (2.4e-7 past 4 rad) in float32, and the arithmetic's.
inline constexpr double kSingleMaxError_rad = 3.5e-7;
/// Of that, the arithmetic's: about a reference, a few roundings of the angle from there, and by the branch-free
/// arctangent near the pole and the seam. References stand in parts of a row of at most kSinglePart columns.
inline constexpr double kSingleArithmetic = 5e-7;
inline constexpr double kSingleArithmetic_rad = 3e-8;
inline constexpr int kSinglePart = 512;
inline constexpr double kSingleFarArithmetic_rad = 1e-7;
inline constexpr double kSingleSolidAngleMaxError = 1e-6;
inline constexpr double kSingleCosineMaxError = 3e-7;

}  // namespace scatmap
