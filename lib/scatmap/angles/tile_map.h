#pragma once
#include "scatmap/angles/angle_map.h"

namespace scatmap {

/// How a frame is cut into tiles of kTileRows rows by `columns`, one Taylor polynomial along each row of a tile, of the
/// least degree whose remainder is at most truncation_rad (taylor_remainder_rad). Tiles where none is, or where the
/// pole, the seam or the horizon lies, are left to angle_row. For the methods `tile` (float) and `vector` (double).
struct TilePlan {
  int columns = 0;
  double truncation_rad = 0;
  double polynomial_share = 0;  ///< of the pixels of sixteen tiles spread over the frame: done by polynomials
};

/// The cheapest plan, of 64 to 1024 columns.
template <class T>
TilePlan plan_tiles(const SampleView& view, int rows, int columns, double truncation_rad);

/// Fills the maps that are not empty; theta and phi come together, the other maps are angle_row's. Error of the angles:
/// the plan's truncation_rad and what angle_row's may be. Allocates nothing.
template <class T>
void write_tile_map(const SampleView& view, const TilePlan& plan, AngleMapOf<T>& map);

}  // namespace scatmap
