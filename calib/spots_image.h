#pragma once
#include <optional>

#include "scatmap/base/grid.h"
#include "scatmap/base/mask.h"
#include "scatmap/counts/dark.h"

namespace scatmap::calib {

/// One frame as the spot finder sees it: net electrons and their noise. Variance of a pixel that expects E electrons of
/// light: floor + max(E, 0).
struct SpotImage {
  Grid<double> net_e;     ///< rows × columns, dark or background taken off; saturated pixels keep their cut-off value
  Grid<double> floor_e2;  ///< read noise, dark shot noise, quantisation and the error of the dark
  Grid<Mask> mask;        ///< not 0: the pixel is no measurement (kSaturated, kBloom, kHot, kNoData)
  double background_e = 0;  ///< median of net_e
};

/// @param dark master dark of the same exposure; none: the frame's own median is taken off and the scatter between
/// neighbouring pixels, when it exceeds the stated read noise, is the floor.
/// @throws Error if frame and dark differ in size, the sensor's gain or saturation is not positive, or no
/// pixel is finite
SpotImage spot_image(const Frame& frame, const std::optional<MasterDark>& dark, const SensorModel& sensor);

/// Marks isolated bright pixels kHot. A pixel is one when it stands kHotPixelSigmas above its surroundings and its four
/// neighbours share less than kHotNeighbourShare of the excess: no Gaussian spot wider than 0.4 px (standard deviation)
/// does that. Pixels masked kNoData, kBad or kHot before are passed over. @return how many were found
std::size_t mark_hot_pixels(SpotImage& image);
/// Puts the median of the neighbours in the place of every pixel that is kHot, kBad or kNoData, so that it raises no
/// spot.
void fill_hot_pixels(SpotImage& image);

/// Sums of factor × factor pixels. Filled pixels count as filled, up to a tenth of a sum; saturated ones mask it.
/// Position x of the result is x·factor + (factor − 1)/2 of the image. Rows and columns that fill no sum at the far
/// edges are left out.
SpotImage binned(const SpotImage& image, int factor);

inline constexpr double kHotPixelSigmas = 6;
inline constexpr double kHotNeighbourShare = 0.05;

}  // namespace scatmap::calib
