#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "scatmap/angles/angle_row.h"
#include "scatmap/base/rotation.h"

namespace scatmap {

/// OpenCV's lens: pinhole, rational radial distortion, tangential and thin-prism terms. mrcal's LENSMODEL_OPENCV4, 5, 8
/// and 12 are its first parameters, the rest 0.
///   x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶)/(1 + k4 r² + k5 r⁴ + k6 r⁶) + 2 p1 x y + p2 (r² + 2 x²) + s1 r² + s2 r⁴,
/// y' with x, y and p1, p2 exchanged and s3, s4; pixel = (fx x' + cx, fy y' + cy), integers at pixel centres.
struct OpencvLens {
  double fx = 0, fy = 0, cx = 0, cy = 0;
  std::array<double, 12> k{};  ///< k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4
};

/// nullopt if `model` is none of the four. @param intrinsics as in the .cameramodel: fx fy cx cy, then the coefficients
std::optional<OpencvLens> opencv_lens(std::string_view model, std::span<const double> intrinsics);

/// Where a row's rays go: ray = (x, y, 1) in camera axes.
struct LensRow {
  std::span<double> x, y;
  std::span<double> solid_angle_sr;  ///< of one pixel, by the lens's Jacobian; may be empty
};

/// Rays of a row of pixels by Newton's method, in vector instructions, then one by one where that has not converged;
/// NaN where the lens has no answer on its unfolded side: between its axis and the first place where its image folds
/// back or a denominator passes 0, looked for in kLensFoldSteps steps of angle. Error: the ray projects onto the pixel
/// within kLensMaxError_px.
void unproject_row(const OpencvLens& lens, int row, ColumnRange columns, const LensRow& out);

/// Angles behind the lens: unproject_row, then both angles of sample_from_camera·ray. NaN and kNoData where there is no
/// ray, NaN and kBelowHorizon below the horizon. cos_theta_s and projected_solid_angle_sr must be empty.
/// Error: kVectorMaxError_rad besides the ray's.
void lens_angle_row(const OpencvLens& lens, const Matrix3<double>& sample_from_camera, int row, ColumnRange columns,
                    const AngleRow<double>& out);

/// Or four units in the last place of the pixel position's distance from the centre, or what two units in the last
/// places of the ray move it by, where that is more.
inline constexpr double kLensMaxError_px = 1e-12;
inline constexpr int kLensFoldSteps = 64;

}  // namespace scatmap
