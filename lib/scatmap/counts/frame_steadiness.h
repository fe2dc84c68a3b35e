#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "scatmap/counts/dark.h"

namespace scatmap {

/// How a frame compares with the mean of its exposure's frames, over the pixels in which that mean shows much light:
/// more than kBrightSigmas of a frame's noise above the dark. (Chosen by one of the frames, they would favour it.)
struct FrameChange {
  double net_dn = 0;          ///< sum above the dark
  std::size_t differing = 0;  ///< pixels that neither noise nor kFrameDriftAllowance explains (reduce.h)
};
struct FrameChanges {
  std::vector<FrameChange> of_frame;
  std::size_t pixels = 0;  ///< bright ones that were looked at
  double u_net_dn = 0;     ///< noise of one frame's net_dn
};
inline constexpr double kBrightSigmas = 10;

/// @param row_step  every so many rows are looked at. The same at any number of threads. @pre shapes agree
FrameChanges frame_changes(std::span<const Frame> frames, const MasterDark& dark, const SensorModel& sensor,
                           int row_step);

}  // namespace scatmap
