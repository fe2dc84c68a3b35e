#pragma once
#include <memory>
#include <optional>
#include <span>

#include "scatmap/angles/pixel_plane.h"
#include "scatmap/base/grid.h"
#include "scatmap/brdf/pose_tiles.h"

namespace scatmap {

/// Standard uncertainty of the BRDF from the calibration covariance of the geometry: the norm of one sensitivity per
/// independent direction of the covariance. Each has three parts: solid angle, cos theta_s, and the shift of
/// directions, f's gradient times the distance in pixels by which features move when the half vector of every pixel
/// changes (features near the specular direction are functions of the half vector, so errors of incidence and of
/// scatter add as they do there).
///
/// Computed through PoseTiles: error below kPoseMaxError of the largest relative effect.
///
/// @param expected_per_sr  rows × columns, smooth estimate of f, for the gradient; masked pixels NaN
/// @return rows × columns, sr^-1; nullopt if the instrument has no calibrated parameter
std::optional<Grid<float>> pose_uncertainty(const Instrument& instrument, const Pose& pose,
                                            const Grid<double>& expected_per_sr);

/// The same, cause by cause, for sums over pixels: signed change of f at one standard deviation of each independent
/// direction of the calibration covariance.
class PoseSensitivities {
 public:
  /// @param instrument with a calibration; @param expected_per_sr as above, must outlive this
  PoseSensitivities(const Instrument& instrument, const Pose& pose, const Grid<double>& expected_per_sr);
  ~PoseSensitivities();
  PoseSensitivities(const PoseSensitivities&) = delete;
  PoseSensitivities& operator=(const PoseSensitivities&) = delete;

  std::size_t count() const;  ///< independent directions
  /// sr^-1, `out` of size count(); NaN where expected_per_sr is.
  void at(int row, int column, std::span<double> out) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

}  // namespace scatmap
