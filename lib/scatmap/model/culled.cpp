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
constexpr int kLeafColumns = kChunk, kLeafRows = 32;
constexpr int kSmallestCubic = 4096;

// A guess, to save the cost of a bound that would not do: what a cubic misses in the smallest tile that is given one,
// if a term that varies by a part v of itself behaves like exp(v x). Its fourth coefficient is then v⁴/24 of it.
double likely_cubic_error(const Interval& value, const Tile& tile) {
  const double shrink = std::min(1.0, 2 * std::sqrt(kSmallestCubic) / (tile.columns + tile.rows));
  return value.high * std::pow(shrink * value.width() / value.high, 4) / (24 * 16 * 8);
}

struct Divided {
  TileTerms smooth, rest;
};

// Terms that may fit a cubic within `allowed`, with the constant, and the others. What falls by half across a tile fits
// no cubic to any tolerance worth having.
Divided divided(const TileTerms& terms, const Tile& tile, double allowed) {
  Divided out{terms, terms};
  out.smooth.active.clear();
  out.rest.active.clear();
  out.rest.constant_per_sr = 0;
  const double share = allowed / static_cast<double>(terms.active.size());
  for (std::size_t j = 0; j < terms.active.size(); ++j) {
    const Interval& v = terms.values[j];
    const bool smooth = v.width() <= 0.5 * v.high && likely_cubic_error(v, tile) <= share;
    (smooth ? out.smooth : out.rest).active.push_back(terms.active[j]);
  }
  return out;
}

// Whether halving a tile may help where `divided` finds nothing smooth: not if the term is all but constant already.
bool may_become_smooth(const Interval& v) { return v.width() > 0.5 * v.high; }

// What is still to be done in a tile.
struct Task {
  bool try_cubic;  ///< no cubic was found so far, and there is hope
  Fill fill;
};

class Culling {
 public:
  Culling(const ModelKernel& kernel, const DirectionPlane& plane, const ModelTolerance& tolerance, double* values,
          std::size_t stride)
      : kernel_(kernel), plane_(plane), tolerance_(tolerance), values_(values), stride_(stride) {}

  void fill(const Tile& tile, const TileTerms& above, Task task) const {
    const TileTerms terms = narrowed(above, kernel_, plane_, tile, 0, tolerance_, kLeftOutShare);
    if (terms.cos_theta_s.high <= 0) return fill(tile, std::numeric_limits<double>::quiet_NaN(), task.fill);
    const bool horizon = terms.cos_theta_s.low <= 0;
    if (terms.active.empty() && !horizon) return fill(tile, terms.constant_per_sr, task.fill);
    if (task.try_cubic && !horizon && tile.area() >= kSmallestCubic && !terms.active.empty()) {
      const double allowed = kCubicShare * terms.allowed_per_sr(tolerance_);
      const Divided parts = divided(terms, tile, allowed);
      if (!parts.smooth.active.empty()) {
        const Curvature<4> c = curvature<4>(parts.smooth, kernel_, plane_, tile, 0.5);
        if (cubic_remainder_per_sr(c, tile) <= allowed) {
          fill_cubic(parts.smooth, kernel_, plane_, tile, at(tile), stride_, task.fill);
          return parts.rest.active.empty() ? void() : fill_parts(tile, parts.rest, {false, Fill::kAdd});
        }
        const Tile smallest{0, 0, std::min(tile.columns, kChunk), std::min(tile.rows, kSmallestCubic / kChunk)};
        // Bounds shrink with the tile a little faster than the fourth power.
        constexpr double kHope = 10;
        task.try_cubic = cubic_remainder_per_sr(c, smallest) <= kHope * allowed;
      } else {
        task.try_cubic = std::any_of(terms.values.begin(), terms.values.end(), may_become_smooth);
      }
    }
    const bool leaf = tile.columns <= kLeafColumns && tile.rows <= kLeafRows;
    if (leaf || (!task.try_cubic && nowhere_small(terms))) return compute(tile, terms, horizon, task.fill);
    fill_parts(tile, terms, task);
  }

 private:
  // No part of the tile can do without any of its terms: no use in looking closer.
  bool nowhere_small(const TileTerms& terms) const {
    const double allowed = terms.allowed_per_sr(tolerance_);
    return std::all_of(terms.values.begin(), terms.values.end(), [&](const Interval& v) { return v.low > allowed; });
  }

  void fill_parts(const Tile& tile, const TileTerms& terms, Task task) const {
    Tile first = tile, second = tile;
    if (tile.columns > kLeafColumns && tile.columns >= 2 * tile.rows) {
      // Whole chunks on the left.
      first.columns = (tile.columns / 2 + kChunk - 1) / kChunk * kChunk;
      second.column += first.columns;
      second.columns -= first.columns;
    } else {
      first.rows = tile.rows / 2;
      second.row += first.rows;
      second.rows -= first.rows;
    }
    fill(first, terms, task);
    fill(second, terms, task);
  }

  double* at(const Tile& tile, int row = 0) const {
    return values_ + static_cast<std::size_t>(tile.row + row) * stride_ + static_cast<std::size_t>(tile.column);
  }

  void fill(const Tile& tile, double value, Fill how) const {
    for (int row = 0; row < tile.rows; ++row) {
      double* const out = at(tile, row);
      if (how == Fill::kAssign) {
        std::fill_n(out, tile.columns, value);
      } else if (value != 0) {
        for (int c = 0; c < tile.columns; ++c) out[c] += value;
      }
    }
  }

  void compute(const Tile& tile, const TileTerms& terms, bool horizon, Fill how) const {
    DirectionChunk chunk;
    alignas(64) ChunkRow sum;
    for (int row = 0; row < tile.rows; ++row) {
      for (int column = 0; column < tile.columns; column += kChunk) {
        const int count = std::min(kChunk, tile.columns - column);
        double* const out = at(tile, row) + column;
        fill_chunk(plane_, kernel_.wi(), tile.column + column, tile.row + row, chunk);
        std::fill(std::begin(sum), std::end(sum), terms.constant_per_sr);
        if (how == Fill::kAdd) {
          for (int c = 0; c < count; ++c) sum[c] += out[c];
        }
        kernel_.add(chunk, terms.active, Amplitudes::kDouble, sum);
        if (horizon) mask_below_horizon(chunk, sum);
        std::copy_n(sum, count, out);
      }
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
  Culling(kernel, plane, tolerance, values, stride).fill(tile, all_terms(kernel), {true, Fill::kAssign});
}

}  // namespace scatmap
