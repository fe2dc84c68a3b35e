#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace scatmap {

/// One exposure time of a flat series: means over pixels and frames of x^k, x = raw − bias, flat minus dark. Means of
/// powers and not powers of the mean, so that the light need not be uniform.
struct LinearityPoint {
  double exposure_s = 0;
  std::array<double, 4> moment{};  ///< k = 1 … 4, DN^k
  double u_relative = 0;           ///< counting noise of moment[0], relative
};

/// A polynomial as SensorModel::linearity has it, and what it leaves.
struct LinearityFit {
  std::vector<double> coefficients;  ///< no more than the series shows to be needed; may be none
  double largest_residual = 0;       ///< of the corrected signals from proportionality to the exposure time, relative
  double u_full = 0;  ///< relative standard uncertainty of the correction at full range against no signal
  /// Half width that holds what is left between any two levels: residual and √3 standard uncertainties together.
  double left() const;
};

/// How well light and shutter of a flat series are thought to repeat at best: residuals below are not over-interpreted.
inline constexpr double kLightStability = 1e-4;

/// Least squares on corrected(x) − corrected(dark) = a·t, corrected = x (1 + c0 x + c1 x² + c2 x³), relative residuals
/// (EMVA 1288 release 3.1, 6.7, weighs in the same way). A coefficient must improve the fit at 99 % (F test).
/// @param range_dn linear range, saturation − bias
/// @returns nothing with fewer than four points
std::optional<LinearityFit> fit_linearity(std::span<const LinearityPoint> points, double range_dn);

}  // namespace scatmap
