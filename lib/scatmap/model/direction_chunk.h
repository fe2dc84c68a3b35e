#pragma once
#include "scatmap/base/direction.h"
#include "scatmap/model/direction_plane.h"

namespace scatmap {

/// Pixels that a kernel evaluates at once: a few vector registers' worth, and all its rows stay in the first cache.
inline constexpr int kChunk = 64;

using ChunkRow = double[kChunk];

/// Scattered directions of kChunk neighbouring pixels and their sums with the incident one, sample axes.
struct DirectionChunk {
  alignas(64) ChunkRow ws_x;
  alignas(64) ChunkRow ws_y;
  alignas(64) ChunkRow ws_z;
  alignas(64) ChunkRow sum_x;
  alignas(64) ChunkRow sum_y;
  alignas(64) ChunkRow sum_z;
};

/// Pixels column .. column + kChunk − 1 of a row; fractional positions and pixels off the array have directions too.
void fill_chunk(const DirectionPlane& plane, const Vector3<double>& wi, double column, double row,
                DirectionChunk& chunk);
/// A square block of kBlock × kBlock pixels from (column, row) on, row after row.
void fill_block(const DirectionPlane& plane, const Vector3<double>& wi, double column, double row,
                DirectionChunk& chunk);
inline constexpr int kBlock = 8;
static_assert(kBlock * kBlock == kChunk);
/// `count` <= kChunk directions, ws_x etc. already filled that far: fills the rest with the last and adds wi.
void complete_chunk(const Vector3<double>& wi, int count, DirectionChunk& chunk);

/// NaN where a direction is not above the horizon (ws_z <= 0 or NaN).
void mask_below_horizon(const DirectionChunk& chunk, ChunkRow& values);

}  // namespace scatmap
