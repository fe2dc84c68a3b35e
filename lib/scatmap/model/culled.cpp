#include "scatmap/model/culled.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scatmap/model/tile_polynomial.h"

namespace scatmap {
namespace {

// Parts of the tolerance; the rest is for the rounding of what is computed.
constexpr double kLeftOutShare = 0.4, kCubicShare = 0.5;

// A tile of this size is not halved any more; one smaller than kSmallestCubic is computed sooner than its curvature.
constexpr int kLeafColumns = kChunk, kLeafRows = 16;
constexpr int kSmallestCubic = 4096;

// Terms that fall by half across a tile do not fit a cubic to any tolerance worth having.
bool smooth(const TileTerms& terms) {
  return std::all_of(terms.values.begin(), terms.values.end(),
                     [](const Interval& v) { return v.width() <= 0.5 * v.high; });
}

// A guess, to save the cost of a bound that would not do: what a cubic misses in the smallest tile that is given one,
// if a term that varies by a part v of itself behaves like exp(v x). Its fourth coefficient is then v⁴/24 of it.
double likely_cubic_error(const TileTerms& terms, const Tile& tile) {
  const double shrink = std::min(1.0, 2 * std::sqrt(kSmallestCubic) / (tile.columns + tile.rows));
  double error = 0;
  for (const Interval& v : terms.values) error += v.high * std::pow(shrink * v.width() / v.high, 4) / (24 * 16 * 8);
  return error;
}

class Culling {
 public:
  Culling(const ModelKernel& kernel, const DirectionPlane& plane, const ModelTolerance& tolerance, double* values,
          std::size_t stride)
      : kernel_(kernel), plane_(plane), tolerance_(tolerance), values_(values), stride_(stride) {}

  void fill(const Tile& tile, const TileTerms& above, bool try_cubic) {
    const TileTerms terms = narrowed(above, kernel_, plane_, tile, 0, tolerance_, kLeftOutShare);
    if (terms.cos_theta_s.high <= 0) return fill(tile, std::numeric_limits<double>::quiet_NaN());
    const bool horizon = terms.cos_theta_s.low <= 0;
    if (terms.active.empty() && !horizon) return fill(tile, terms.constant_per_sr);
    const bool leaf = tile.columns <= kLeafColumns && tile.rows <= kLeafRows;
    const double allowed = kCubicShare * terms.allowed_per_sr(tolerance_);
    if (try_cubic && !horizon && tile.area() >= kSmallestCubic && smooth(terms) &&
        likely_cubic_error(terms, tile) <= allowed) {
      const Curvature<4> c = curvature<4>(terms, kernel_, plane_, tile, 0.5);
      if (cubic_remainder_per_sr(c, tile) <= allowed)
        return fill_cubic(terms, kernel_, plane_, tile, at(tile), stride_);
      const Tile smallest{0, 0, std::min(tile.columns, kChunk), std::min(tile.rows, kSmallestCubic / kChunk)};
      // Bounds shrink with the tile a little faster than the fourth power.
      constexpr double kHope = 10;
      try_cubic = cubic_remainder_per_sr(c, smallest) <= kHope * allowed;
    }
    if (leaf) return compute(tile, terms, horizon);
    Tile first = tile, second = tile;
    if (tile.columns > kLeafColumns && tile.columns >= 2 * tile.rows) {
      // Whole chunks on the left.
      first.columns = (tile.columns / 2 + kChunk - 1) / kChunk * kChunk;
      second.column += first.columns;
      second.columns -= first.columns;
    } else if (tile.rows > kLeafRows) {
      first.rows = tile.rows / 2;
      second.row += first.rows;
      second.rows -= first.rows;
    } else {
      first.columns = kChunk;
      second.column += kChunk;
      second.columns -= kChunk;
    }
    fill(first, terms, try_cubic);
    fill(second, terms, try_cubic);
  }

 private:
  double* at(const Tile& tile, int row = 0) const {
    return values_ + static_cast<std::size_t>(tile.row + row) * stride_ + static_cast<std::size_t>(tile.column);
  }

  void fill(const Tile& tile, double value) const {
    for (int row = 0; row < tile.rows; ++row) std::fill_n(at(tile, row), tile.columns, value);
  }

  void compute(const Tile& tile, const TileTerms& terms, bool horizon) const {
    DirectionChunk chunk;
    alignas(64) ChunkRow sum;
    for (int row = 0; row < tile.rows; ++row) {
      fill_chunk(plane_, kernel_.wi(), tile.column, tile.row + row, chunk);
      std::fill(std::begin(sum), std::end(sum), terms.constant_per_sr);
      kernel_.add(chunk, terms.active, Amplitudes::kDouble, sum);
      if (horizon) mask_below_horizon(chunk, sum);
      std::copy_n(sum, tile.columns, at(tile, row));
    }
  }

  const ModelKernel& kernel_;
  const DirectionPlane& plane_;
  const ModelTolerance& tolerance_;
  double* values_;
  std::size_t stride_;
};

}  // namespace

void culled_tile(const ModelKernel& kernel, const DirectionPlane& plane, const ModelTolerance& tolerance,
                 const Tile& tile, double* values, std::size_t stride) {
  Culling(kernel, plane, tolerance, values, stride).fill(tile, all_terms(kernel), true);
}

}  // namespace scatmap
