#pragma once
#include <vector>

#include "scatmap/angles/pixel_plane.h"
#include "scatmap/brdf/brdf_map.h"

namespace scatmap {

/// A grid as it is drawn: columns grow in-plane (towards larger theta_s), rows out-of-plane (towards +y).
struct Raster {
  int columns = 0;
  int rows = 0;
  int block = 1;              ///< pixels of the map along each side of one raster cell
  std::vector<float> values;  ///< row after row; NaN where a cell has no good pixel
  double first_x_deg = 0;     ///< scatter angle of the first cell's centre from the frame's centre
  double first_y_deg = 0;
  double step_x_deg = 0;  ///< > 0
  double step_y_deg = 0;  ///< > 0

  /// From edge to edge, deg.
  double width_deg() const { return columns * step_x_deg; }
  double height_deg() const { return rows * step_y_deg; }
};

/// Means of square blocks, as large as needed for at most `most_cells` along a side; the last block of a row or column
/// may be narrower. Good pixels only. The mean, not the maximum: maxima lift the noise floor of a measured map against
/// a model's and let single hot pixels grow; of a lobe 5 px wide at half height the mean keeps three quarters at blocks
/// of 4 and half at blocks of 7, a sixth to a third of a decade on a scale of many.
Raster raster(const Grid<double>& values, const Grid<Mask>& mask, const SampleView& view, int most_cells);
Raster raster(const Grid<float>& values, const Grid<Mask>& mask, const SampleView& view, int most_cells);

}  // namespace scatmap
