#pragma once
#include <span>

#include "scatmap/model/direction_plane.h"
#include "scatmap/model/model_kernel.h"
#include "scatmap/model/model_method.h"
#include "scatmap/model/tile.h"

namespace scatmap {

struct FrameModelOptions {
  ModelMethod method = ModelMethod::kExact;
  double tolerance_rel = kDefaultModelTolerance;  ///< of kCulled and of pixel averages
  /// Means over the pixels (pixel_average.h) instead of values at their centres; the method is then not used.
  bool pixel_average = false;
};

/// A model on a frame of a flat detector's pixels, by any method.
class FrameModel {
 public:
  /// `wi`: unit vector towards the source, sample axes.
  /// @throws Error if the detector's distance is not a number > 0
  FrameModel(const Model& model, const Vector3<double>& wi, double detector_distance_m, const DirectionPlane& plane,
             int rows, int columns, const FrameModelOptions& options);

  /// BRDF in 1/sr of every pixel, row after row: `values` has rows × columns. NaN below the horizon. On oneTBB's
  /// threads; the same bytes at any number of them. Needs no memory beside its result.
  void fill(std::span<double> values) const;

 private:
  void fill_rows(std::span<double> values) const;
  void fill_tiles(std::span<double> values) const;

  PreparedModel exact_;
  ModelKernel kernel_;
  DirectionPlane plane_;
  int rows_, columns_;
  FrameModelOptions options_;
};

}  // namespace scatmap
