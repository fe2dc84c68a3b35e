#pragma once
#include <span>

#include "scatmap/angles/angle_map.h"
#include "scatmap/base/method_bound.h"
#include "scatmap/brdf/pose_tiles.h"
#include "scatmap/counts/reduce.h"

namespace scatmap {

/// Rows of a band that one thread takes at a time: as many as a tile of u_pose has.
inline constexpr int kFusedBand = kPoseTile;

/// The frames of one exposure, and what turns them into map units.
struct FusedFrames {
  std::span<const Frame> frames;
  const MasterDark& dark;
  const SensorModel& sensor;
  const PixelResponse& response;
  double exposure_s;
  double factor;  ///< map units per DN/s: ND stack and signature
};

/// Where the light of each pixel comes from: a flat detector's view, or angles computed before (lens).
struct FusedGeometry {
  const SampleView& view;
  const AngleMap* angles = nullptr;  ///< used instead of the view where given
  const PoseTiles* pose = nullptr;   ///< for u_pose; nullptr: no calibration
};

/// What one pass gives: rows × columns, NaN where the mask is not 0. Planes that are empty when the pass begins are
/// allocated; planes of the right shape are filled again, which saves touching fresh memory. T: float or double; the
/// pass itself is in float, but where small differences count.
template <class T>
struct FusedPlanes {
  Grid<T> brdf_per_sr;
  Grid<float> u_random_per_sr;
  Grid<float> u_pose_per_sr;   ///< empty without a calibration
  Grid<float> u_total_per_sr;  ///< random and pose together; scale and other causes excluded. With `with_total` only
  Grid<Mask> mask;
  Grid<double> expected_per_sr;  ///< smooth estimate behind the variances; with `with_expected` only
};

struct FusedOptions {
  bool with_total = true;
  bool with_expected = false;
};

/// The `fused` method of counts → BRDF for one exposure: from raw frames to the map, its uncertainty parts and mask in
/// one pass over blocks that stay in the caches, without whole intermediate images. Against `exact` (reduce, merge,
/// angle_map, division, pose_uncertainty) masks and NaNs are the same, BRDF within kFusedBrdfMaxError of
/// |f| + sqrt(frames) u_random, u_random within kFusedUncertaintyMaxError, u_pose and u_total within kFusedPoseMaxError
/// of u_total. The same bytes for any number of threads. Memory: the planes, and some 100 KiB per thread.
/// @throws Error as reduce
template <class T>
void fused_map(const FusedFrames& frames, const FusedGeometry& geometry, const FusedOptions& options,
               FusedPlanes<T>& out);

inline constexpr double kFusedBrdfMaxError = 5e-7;  ///< eight roundings of a float
inline constexpr double kFusedUncertaintyMaxError = 1e-6;
/// u_pose and u_total, of u_total: two float roundings of a quadratic form, and those of the noise behind its
/// gradients; with one or two calibrated parameters, whose effects can cancel, kPoseMaxError.
inline constexpr double kFusedPoseMaxError = 1e-4;

std::span<const MethodBound> brdf_bounds();

}  // namespace scatmap
