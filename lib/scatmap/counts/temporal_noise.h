#pragma once
#include <span>
#include <vector>

#include "scatmap/frame/frame.h"

namespace scatmap {

/// Which pixels count, row by row.
using PixelUse = std::vector<bool>;

/// Differences of a pair of frames so many standard deviations off are hits; noise goes so far once in 4e11.
inline constexpr double kHitSigmas = 7;

/// Temporal mean and variance of frames of one exposure, DN and DN².
struct TemporalNoise {
  double mean = 0, variance = 0;
  double values = 0;  ///< independent differences behind the variance
  double u_variance() const;
};

/// From pairs of successive frames (EMVA 1288 R3.1, 6.6): the spatial pattern cancels in their difference, whose mean
/// is drift of the light. Hits count in no variance, and in the mean as the lower value for both. NaN where no pixel
/// has two values. @pre two frames or more, of one shape, `use` of their size
TemporalNoise temporal_noise(std::span<const Frame> frames, const PixelUse& use);

}  // namespace scatmap
