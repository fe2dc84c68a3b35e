#pragma once
#include <span>

#include "scatmap/angles/angle_line.h"
#include "scatmap/angles/angle_map.h"

namespace scatmap {

/// The `linear` method: both angles as linear functions of column and row about the frame's middle, the small-angle map
/// that many laboratories use.
class LinearMap {
 public:
  LinearMap(const SampleView& view, int rows, int columns);
  /// One row of it, `columns` long; NaN where nothing is seen.
  void row(int row, std::span<float> theta_s_rad, std::span<float> phi_s_rad) const;

 private:
  struct Step {
    double theta, phi;
  };
  static Step step(const WideRay& middle, const Vector3<double>& step);
  SampleView view_;
  int columns_;
  double middle_row_, middle_column_, theta_, phi_;
  Step along_, down_;
};

/// Fills the maps that are not empty; solid angle and mask are the `single` method's.
void write_linear_map(const SampleView& view, AngleMapOf<float>& map);

/// Its error on this frame, rad: what the first degree leaves out (taylor_remainder_rad towards the farthest corner),
/// and rounding. Infinite if the pole is nearer than about two half diagonals.
double linear_bound_rad(const SampleView& view, int rows, int columns);

}  // namespace scatmap
