#include "scatmap/model/direction_chunk.h"

#include <cmath>
#include <limits>

#include "scatmap/base/simd.h"

namespace scatmap {

namespace {

// Pixel i of the chunk at (column + i mod width, row + i / width).
template <int kWidth>
SCATMAP_INLINE void fill(const DirectionPlane& plane, const Vector3<double>& wi, double column, double row,
                         DirectionChunk& chunk) {
  const Vector3<double> start = plane.at(column, row);
  const double x0 = start.x(), y0 = start.y(), z0 = start.z();
  const double cx = plane.column_step.x(), cy = plane.column_step.y(), cz = plane.column_step.z();
  const double rx = plane.row_step.x(), ry = plane.row_step.y(), rz = plane.row_step.z();
  const double wi_x = wi.x(), wi_y = wi.y(), wi_z = wi.z();
  for (int i = 0; i < kChunk; ++i) {
    const double c = i % kWidth, r = i / kWidth;
    const double x = x0 + c * cx + r * rx, y = y0 + c * cy + r * ry, z = z0 + c * cz + r * rz;
    const double per_length = 1 / std::sqrt(x * x + y * y + z * z);
    const double ux = x * per_length, uy = y * per_length, uz = z * per_length;
    chunk.ws_x[i] = ux;
    chunk.ws_y[i] = uy;
    chunk.ws_z[i] = uz;
    chunk.sum_x[i] = wi_x + ux;
    chunk.sum_y[i] = wi_y + uy;
    chunk.sum_z[i] = wi_z + uz;
  }
}

}  // namespace

SCATMAP_CLONES
void fill_chunk(const DirectionPlane& plane, const Vector3<double>& wi, double column, double row,
                DirectionChunk& chunk) {
  fill<kChunk>(plane, wi, column, row, chunk);
}

SCATMAP_CLONES
void fill_block(const DirectionPlane& plane, const Vector3<double>& wi, double column, double row,
                DirectionChunk& chunk) {
  fill<kBlock>(plane, wi, column, row, chunk);
}

void complete_chunk(const Vector3<double>& wi, int count, DirectionChunk& chunk) {
  for (int i = count; i < kChunk; ++i) {
    chunk.ws_x[i] = chunk.ws_x[count - 1];
    chunk.ws_y[i] = chunk.ws_y[count - 1];
    chunk.ws_z[i] = chunk.ws_z[count - 1];
  }
  for (int i = 0; i < kChunk; ++i) {
    chunk.sum_x[i] = wi.x() + chunk.ws_x[i];
    chunk.sum_y[i] = wi.y() + chunk.ws_y[i];
    chunk.sum_z[i] = wi.z() + chunk.ws_z[i];
  }
}

SCATMAP_CLONES
void mask_below_horizon(const DirectionChunk& chunk, ChunkRow& values) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < kChunk; ++i) {
    // A sum, so that a NaN in any component of the direction comes out, as it does of PreparedModel.
    const double nothing = (chunk.ws_x[i] + chunk.ws_y[i]) * 0;
    values[i] = chunk.ws_z[i] > 0 ? values[i] + nothing : kNaN;
  }
}

}  // namespace scatmap
