#pragma once
#include <span>
#include <vector>

#include "scatmap/counts/reduce.h"

namespace scatmap {

/// One exposure's counts on the common scale of the map: value = rate × factor.
struct ScaledCounts {
  const Counts* counts;
  double factor;   ///< map units per DN/s: ND stacks and signature
  int dark_group;  ///< exposures of one group share one master dark, and with it its error
};

/// All exposures of one pose as one image, in map units.
struct Merged {
  Grid<double> value;              ///< NaN where masked
  Grid<double> expected;           ///< best local estimate (expected_signal), for variances and gradients
  Grid<float> variance;            ///< at the expected value; independent from pixel to pixel
  Grid<Mask> mask;                 ///< 0 where at least one exposure is good, else why each is not
  std::vector<Grid<float>> share;  ///< per exposure: weight of its pixel, summing to 1; one exposure: empty (all 1)
};

/// Weights are inverse *expected* variances (Poisson and read noise at the merged estimate, twice iterated), never
/// measured ones: those favour pixels that fluctuate down. A master dark shared by exposures is one correlated error.
/// @param exposures one or more, equal shapes
Merged merge(std::span<const ScaledCounts> exposures);

/// `value` and `mask` alone, weighted once, at what the most sensitive good exposure shows: a third of the time. Good
/// for predicting a pixel from its neighbours; as a result its faint pixels would be biased.
Merged merge_once(std::span<const ScaledCounts> exposures);

}  // namespace scatmap
