#include "scatmap/model/tile_polynomial.h"

#include <array>
#include <cmath>

#include "scatmap/base/simd.h"

namespace scatmap {
namespace {

constexpr std::size_t kNodes = 4;
// cos of 7, 5, 3 and 1 eighths of pi/2.
constexpr std::array<double, kNodes> kNode{-0.92387953251128674, -0.38268343236508977, 0.38268343236508977,
                                           0.92387953251128674};

using Cubic = std::array<double, kNodes>;  // coefficients of 1, x, x², x³

// The cubics that are 1 at one node and 0 at the others.
std::array<Cubic, kNodes> basis_cubics() {
  std::array<Cubic, kNodes> out{};
  for (std::size_t i = 0; i < kNodes; ++i) {
    Cubic p{1, 0, 0, 0};
    for (std::size_t j = 0; j < kNodes; ++j) {
      if (j == i) continue;
      const double scale = 1 / (kNode[i] - kNode[j]);
      for (std::size_t k = kNodes; k-- > 0;) p[k] = ((k > 0 ? p[k - 1] : 0) - kNode[j] * p[k]) * scale;
    }
    out[i] = p;
  }
  return out;
}

double value(const Cubic& p, double x) { return p[0] + x * (p[1] + x * (p[2] + x * p[3])); }

// One dimension of a tile: pixel `first` + i is at x = (2 i − count + 1) / count, half a pixel inside [−1, 1].
double node_position(int first, int count, double x) { return first + (x * count + count - 1) / 2; }

SCATMAP_CLONES
void fill_row(const Cubic& p, int count, double* out, Fill how) {
  const double per_count = 1.0 / count, p0 = p[0], p1 = p[1], p2 = p[2], p3 = p[3];
  const auto cubic = [&](int i) {
    const double x = (2 * i - count + 1) * per_count;
    return p0 + x * (p1 + x * (p2 + x * p3));
  };
  if (how == Fill::kAssign) {
    for (int i = 0; i < count; ++i) out[i] = cubic(i);
  } else {
    for (int i = 0; i < count; ++i) out[i] += cubic(i);
  }
}

}  // namespace

double cubic_remainder_per_sr(const Curvature<4>& curvature, const Tile& tile) {
  const auto error = [](double fourth, int count) { return fourth * std::pow(count / 2.0, 4) / 8; };
  constexpr double kBasis = 1.85;
  return error(curvature.columns[4], tile.columns) + kBasis * error(curvature.rows[4], tile.rows);
}

void fill_cubic(const TileTerms& terms, const ModelKernel& kernel, const DirectionPlane& plane, const Tile& tile,
                double* values, std::size_t stride, Fill how) {
  static const std::array<Cubic, kNodes> kBasis = basis_cubics();
  DirectionChunk chunk;
  for (std::size_t r = 0; r < kNodes; ++r) {
    for (std::size_t c = 0; c < kNodes; ++c) {
      const Vector3<double> ws =
          plane.at(node_position(tile.column, tile.columns, kNode[c]), node_position(tile.row, tile.rows, kNode[r]))
              .normalized();
      chunk.ws_x[r * kNodes + c] = ws.x();
      chunk.ws_y[r * kNodes + c] = ws.y();
      chunk.ws_z[r * kNodes + c] = ws.z();
    }
  }
  complete_chunk(kernel.wi(), kNodes * kNodes, chunk);
  alignas(64) ChunkRow node_values{};
  kernel.add(chunk, terms.active, Amplitudes::kDouble, node_values);
  for (int row = 0; row < tile.rows; ++row) {
    const double y = (2 * row - tile.rows + 1) / static_cast<double>(tile.rows);
    Cubic p{terms.constant_per_sr, 0, 0, 0};
    for (std::size_t r = 0; r < kNodes; ++r) {
      const double weight = value(kBasis[r], y);
      for (std::size_t c = 0; c < kNodes; ++c) {
        for (std::size_t k = 0; k < kNodes; ++k) p[k] += weight * node_values[r * kNodes + c] * kBasis[c][k];
      }
    }
    fill_row(p, tile.columns, values + static_cast<std::size_t>(row) * stride, how);
  }
}

}  // namespace scatmap
