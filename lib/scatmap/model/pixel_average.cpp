#include "scatmap/model/pixel_average.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace scatmap {
namespace {

constexpr double kLeftOutShare = 0.3, kMeanShare = 0.6;
// Computing the derivatives' bounds costs as much as some ten thousand pixels' terms.
constexpr int kLargestColumns = kChunk, kLargestRows = 16, kSmallestRows = 2, kSmallestColumns = 8;
constexpr int kFewParts = 4;  // more than these are worth a look at smaller tiles first

// Means of a tile, row after row.
using Means = std::vector<double>;

class Averaging {
 public:
  Averaging(const ModelKernel& kernel, const DirectionPlane& plane, const ModelTolerance& tolerance, double* values,
            std::size_t stride)
      : kernel_(kernel), plane_(plane), tolerance_(tolerance), values_(values), stride_(stride) {}

  void fill(const Tile& tile, const TileTerms& above) const {
    const TileTerms terms = narrowed(above, kernel_, plane_, tile, 0.5, tolerance_, kLeftOutShare);
    const bool above_horizon = terms.cos_theta_s.low > 0;
    if (terms.cos_theta_s.high <= 0 || (terms.active.empty() && above_horizon)) return store(tile, terms, 0);
    if (tile.columns > kLargestColumns || tile.rows > kLargestRows) return halve(tile, terms);
    const double allowed = kMeanShare * terms.allowed_per_sr(tolerance_);
    const Curvature c = curvature(terms, kernel_, plane_, tile, 0.5);
    // The mean of (x − centre)² over a pixel is 1/12.
    if (above_horizon && c.second_columns + c.second_rows <= 12 * allowed) return store(tile, terms, 0);
    // Gauss's two points miss h⁴ f⁗/4320 of a mean over h, and f⁗ = 24 times the fourth coefficient.
    const double parts = std::pow((c.fourth_columns + c.fourth_rows) / (180 * allowed), 0.25);
    const bool small = tile.columns <= kSmallestColumns && tile.rows <= kSmallestRows;
    if (!small && !(parts <= kFewParts)) return halve(tile, terms);
    if (above_horizon && parts <= kLargestParts)
      return store(tile, terms, std::max(1, static_cast<int>(std::ceil(parts))));
    converge(tile, terms, parts > kLargestParts ? kLargestParts / 4 : 8, allowed / kMeanShare / 10);
  }

 private:
  void halve(const Tile& tile, const TileTerms& terms) const {
    Tile first = tile, second = tile;
    if (tile.columns > kLargestColumns || (tile.rows <= kSmallestRows && tile.columns > kSmallestColumns)) {
      first.columns = tile.columns / 2;
      second.column += first.columns;
      second.columns -= first.columns;
    } else {
      first.rows = tile.rows / 2;
      second.row += first.rows;
      second.rows -= first.rows;
    }
    fill(first, terms);
    fill(second, terms);
  }

  // Sum over a tile of the model at one position within each pixel, (0, 0) the centre.
  void add_points(const Tile& tile, const TileTerms& terms, double dx, double dy, Means& sums) const {
    DirectionChunk chunk;
    alignas(64) ChunkRow row;
    for (int r = 0; r < tile.rows; ++r) {
      fill_chunk(plane_, kernel_.wi(), tile.column + dx, tile.row + r + dy, chunk);
      std::fill(std::begin(row), std::end(row), terms.constant_per_sr);
      kernel_.add(chunk, terms.active, Amplitudes::kDouble, row);
      double* const out = sums.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(tile.columns);
      for (int c = 0; c < tile.columns; ++c) out[c] += chunk.ws_z[c] > 0 ? row[c] : 0;
    }
  }

  // `parts` by `parts` parts of each pixel, two by two Gauss points in each; 0: the centre.
  Means means(const Tile& tile, const TileTerms& terms, int parts) const {
    Means out(static_cast<std::size_t>(tile.area()), 0.0);
    if (parts == 0) {
      add_points(tile, terms, 0, 0, out);
      return out;
    }
    const double gauss = 0.5 / std::sqrt(3.0);
    const auto position = [&](int i) { return (i / 2 + 0.5 + (i % 2 == 0 ? -gauss : gauss)) / parts - 0.5; };
    for (int i = 0; i < 2 * parts; ++i) {
      for (int j = 0; j < 2 * parts; ++j) add_points(tile, terms, position(j), position(i), out);
    }
    for (double& v : out) v /= 4.0 * parts * parts;
    return out;
  }

  void store(const Tile& tile, const Means& means) const {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    for (int r = 0; r < tile.rows; ++r) {
      for (int c = 0; c < tile.columns; ++c) {
        const bool seen = plane_.at(tile.column + c, tile.row + r).z() > 0;
        values_[static_cast<std::size_t>(tile.row + r) * stride_ + static_cast<std::size_t>(tile.column + c)] =
            seen ? means[static_cast<std::size_t>(r * tile.columns + c)] : kNaN;
      }
    }
  }

  void store(const Tile& tile, const TileTerms& terms, int parts) const { store(tile, means(tile, terms, parts)); }

  void converge(const Tile& tile, const TileTerms& terms, int first_parts, double enough_per_sr) const {
    Means last = means(tile, terms, first_parts);
    for (int parts = 2 * first_parts; parts <= kLargestParts; parts *= 2) {
      Means next = means(tile, terms, parts);
      double change = 0;
      for (std::size_t i = 0; i < next.size(); ++i) change = std::max(change, std::abs(next[i] - last[i]));
      last = std::move(next);
      if (change <= enough_per_sr) break;
    }
    store(tile, last);
  }

  const ModelKernel& kernel_;
  const DirectionPlane& plane_;
  const ModelTolerance& tolerance_;
  double* values_;
  std::size_t stride_;
};

}  // namespace

void pixel_average_tile(const ModelKernel& kernel, const DirectionPlane& plane, const ModelTolerance& tolerance,
                        const Tile& tile, double* values, std::size_t stride) {
  Averaging(kernel, plane, tolerance, values, stride).fill(tile, all_terms(kernel));
}

}  // namespace scatmap
