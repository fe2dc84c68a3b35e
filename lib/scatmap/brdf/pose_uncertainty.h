#pragma once
#include <optional>

#include "scatmap/angles/pixel_plane.h"
#include "scatmap/base/grid.h"

namespace scatmap {

/// Standard uncertainty of the BRDF from the calibration covariance of the geometry: the norm of one sensitivity per
/// independent direction of the covariance. Each has three parts: solid angle, cos theta_s, and the shift of directions,
/// f's gradient times the distance in pixels by which features move when the half vector of every pixel changes (features
/// near the specular direction are functions of the half vector, so errors of incidence and of scatter add as they do there).
///
/// @param expected_per_sr  rows × columns, smooth estimate of f, for the gradient; masked pixels NaN
/// @return rows × columns, sr^-1; nullopt if the instrument has no calibrated parameter
std::optional<Grid<float>> pose_uncertainty(const Instrument& instrument, const Pose& pose, const Grid<double>& expected_per_sr);

}  // namespace scatmap
