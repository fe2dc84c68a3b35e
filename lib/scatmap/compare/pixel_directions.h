#pragma once
#include <optional>

#include "scatmap/brdf/brdf_map.h"

namespace scatmap {

/// Where the pixel positions of a map look, sample axes: in closed form for a flat detector, between the pixels of the
/// angle map for one behind a lens.
class PixelDirections {
 public:
  /// @param map must outlive this. @throws Error from sample_view
  explicit PixelDirections(const BrdfMap& map);
  /// Of any length; NaN where the map knows no direction.
  Vector3<double> operator()(PixelPosition at) const;
  /// Of the position that moves by one pixel, from half a pixel before to half a pixel after: exact for a flat
  /// detector.
  Vector3<double> change(PixelPosition at, double columns, double rows) const;

 private:
  const BrdfMap& map_;
  std::optional<SampleView> view_;  // without a lens
};

/// A flat detector that looks at the same centre and has the same mean angle per pixel along its middle column and row:
/// the map's own without a lens, for the scales of pictures with one. @throws Error from sample_view
SampleView mean_view(const BrdfMap& map);

/// By how many pixels the directions of two maps of equal size differ, at most, over corners, edges and centre.
/// Infinity where one of them cannot see what the other sees. With a lens to first order, and only where both have
/// directions. @throws Error from sample_view
double direction_difference_px(const BrdfMap& a, const BrdfMap& b);

}  // namespace scatmap
