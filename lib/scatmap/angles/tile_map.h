#pragma once
#include "scatmap/angles/angle_map.h"

namespace scatmap {

/// How the `tile` method cuts a frame: tiles of kTileRows rows by `columns`, one Taylor polynomial of `degree` along
/// each row of a tile. Tiles where the polynomial could be off by more than truncation_rad, or where the pole, the
/// seam or the horizon lies, are left to the `single` method.
struct TilePlan {
  int columns = 0;
  int degree = 0;
  double truncation_rad = 0;
  double polynomial_share = 0;  ///< of the pixels of sixteen tiles spread over the frame: done by polynomials
};

/// The cheapest plan whose truncation bound (taylor_remainder_rad) holds: degree 1 to 4, 64 to 1024 columns.
TilePlan plan_tiles(const SampleView& view, int rows, int columns, double truncation_rad);

/// Fills the maps that are not empty; theta and phi come together. Error of the angles: the plan's truncation_rad and
/// single_bound_rad of the frame; the other maps are the `single` method's. Allocates nothing.
void write_tile_map(const SampleView& view, const TilePlan& plan, AngleMapOf<float>& map);

}  // namespace scatmap
