#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scatmap/report/gnuplot.h"

namespace scatmap {

/// A spot on the detector and how far from its prediction it was found.
struct SpotResidual {
  double column_px = 0;  ///< of the spot
  double row_px = 0;
  double along_columns_px = 0;  ///< spot less prediction; NaN: nothing is predicted
  double along_rows_px = 0;
  double sigmas = 0;      ///< the same in standard deviations
  bool direct = false;    ///< the straight-through beam, not a mirror
  bool left_out = false;  ///< took no part in the fit
};

/// Arrows on the frame, each from its spot in the direction in which the spot lies from its prediction, all magnified
/// alike by 1, 2 or 5 times a power of ten, so that nine in ten are shorter than a twelfth of the frame's diagonal; an
/// arrow of a stated length shows the scale. Spots that took no part are crosses, with their distance in standard
/// deviations where they are few. Rows grow downwards.
/// @throws Error if there is no spot; from write_picture
void draw_spot_residuals(const std::vector<SpotResidual>& spots, int columns, int rows, const std::string& title,
                         const std::filesystem::path& target, const PictureOptions& options = {});

}  // namespace scatmap
