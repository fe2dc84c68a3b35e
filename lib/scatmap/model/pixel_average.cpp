#include "scatmap/model/pixel_average.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace scatmap {
namespace {

constexpr double kLeftOutShare = 0.3, kMeanShare = 0.6;
constexpr int kLargestColumns = kChunk, kLargestRows = 16;
// The eighth derivatives' bounds cost as much as some hundred points of each pixel of a block.
constexpr int kCheapPoints = 150;

constexpr int kHorizonParts = 4;

// Means of a tile, row after row.
using Means = std::vector<double>;

struct Node {
  double position, weight;  // position from −1/2 to 1/2; the weights add up to 1
};

// Gauss-Legendre points of `order` 2 or 4 in each of `parts` equal parts of a pixel.
std::vector<Node> gauss_nodes(int order, int parts) {
  static constexpr std::array<Node, 2> kTwo{{{-0.28867513459481287, 0.5}, {0.28867513459481287, 0.5}}};
  static constexpr std::array<Node, 4> kFour{{{-0.43056815579702629, 0.17392742256872692},
                                              {-0.16999052179242813, 0.32607257743127307},
                                              {0.16999052179242813, 0.32607257743127307},
                                              {0.43056815579702629, 0.17392742256872692}}};
  std::vector<Node> out;
  for (int part = 0; part < parts; ++part) {
    const auto add = [&](const Node& n) { out.push_back({(part + 0.5 + n.position) / parts - 0.5, n.weight / parts}); };
    if (order == 2) {
      std::for_each(kTwo.begin(), kTwo.end(), add);
    } else {
      std::for_each(kFour.begin(), kFour.end(), add);
    }
  }
  return out;
}

// Points per pixel side that keep the mean within `allowed`, and how they are laid.
struct Rule {
  int order;
  double parts;
  double points() const { return order * order * std::max(1.0, parts * parts); }
};

// A rule of n points misses h^(2n) times this coefficient of order 2n: n!^4/((2n + 1) (2n)!²).
Rule rule_for(const Curvature<8>& c, double allowed) {
  const Rule two{2, std::pow(c.both(4) / (180 * allowed), 1.0 / 4)};
  const Rule four{4, std::pow(c.both(8) * 331776 / (9 * 40320.0 * 40320.0 * allowed), 1.0 / 8)};
  return four.points() < two.points() ? four : two;
}

class Averaging {
 public:
  Averaging(const ModelKernel& kernel, const DirectionPlane& plane, const ModelTolerance& tolerance, double* values,
            std::size_t stride)
      : kernel_(kernel), plane_(plane), tolerance_(tolerance), values_(values), stride_(stride) {}

  void fill(const Tile& tile, const TileTerms& above) const {
    const TileTerms terms = narrowed(above, kernel_, plane_, tile, 0.5, tolerance_, kLeftOutShare);
    const bool above_horizon = terms.cos_theta_s.low > 0;
    if (terms.cos_theta_s.high <= 0) return store(tile, std::numeric_limits<double>::quiet_NaN());
    if (terms.active.empty() && above_horizon) return store(tile, terms.constant_per_sr);
    if (tile.columns > kLargestColumns || tile.rows > kLargestRows) return halve(tile, terms);
    const double allowed = kMeanShare * terms.allowed_per_sr(tolerance_);
    const std::vector<Node> centre{{0, 1}};
    const Curvature<8> c = curvature<8>(terms, kernel_, plane_, tile, 0.5);
    // The mean of (x − centre)² over a pixel is 1/12.
    if (above_horizon && c.both(2) <= 12 * allowed) return store(tile, means(tile, terms, centre));
    const Rule rule = rule_for(c, allowed);
    if (!is_block(tile) && !(above_horizon && rule.points() <= kCheapPoints)) return blocks(tile, terms);
    // No mean converges over a pixel that the horizon cuts: a fixed number of points.
    if (!above_horizon) return store(tile, means(tile, terms, gauss_nodes(2, kHorizonParts)));
    if (rule.parts <= kLargestParts)
      return store(tile, means(tile, terms, gauss_nodes(rule.order, std::max(1, static_cast<int>(rule.parts) + 1))));
    converge(tile, terms, kLargestParts / 8, allowed / kMeanShare / 10);
  }

 private:
  static bool is_block(const Tile& tile) { return tile.columns <= kBlock && tile.rows <= kBlock; }

  double* at(const Tile& tile, int row) const {
    return values_ + static_cast<std::size_t>(tile.row + row) * stride_ + static_cast<std::size_t>(tile.column);
  }

  void halve(const Tile& tile, const TileTerms& terms) const {
    Tile first = tile, second = tile;
    if (tile.columns > kLargestColumns) {
      first.columns = kLargestColumns;
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

  void blocks(const Tile& tile, const TileTerms& terms) const {
    for (int r = 0; r < tile.rows; r += kBlock) {
      for (int c = 0; c < tile.columns; c += kBlock)
        fill({tile.column + c, tile.row + r, std::min(kBlock, tile.columns - c), std::min(kBlock, tile.rows - r)},
             terms);
    }
  }

  // Adds weight times the model at one position within each pixel, (0, 0) its centre.
  void add_points(const Tile& tile, const TileTerms& terms, const Node& x, const Node& y, Means& sums) const {
    DirectionChunk chunk;
    alignas(64) ChunkRow values;
    const bool block = is_block(tile);
    const double weight = x.weight * y.weight;
    for (int r = 0; r < tile.rows; r += block ? kBlock : 1) {
      (block ? fill_block : fill_chunk)(plane_, kernel_.wi(), tile.column + x.position, tile.row + r + y.position,
                                        chunk);
      std::fill(std::begin(values), std::end(values), terms.constant_per_sr);
      kernel_.add(chunk, terms.active, Amplitudes::kDouble, values);
      for (int i = 0; i < (block ? tile.rows : 1); ++i) {
        for (int c = 0; c < tile.columns; ++c) {
          const int from = i * kBlock + c;
          if (chunk.ws_z[from] > 0) sums[static_cast<std::size_t>((r + i) * tile.columns + c)] += weight * values[from];
        }
      }
    }
  }

  Means means(const Tile& tile, const TileTerms& terms, const std::vector<Node>& nodes) const {
    Means out(static_cast<std::size_t>(tile.area()), 0.0);
    for (const Node& y : nodes) {
      for (const Node& x : nodes) add_points(tile, terms, x, y, out);
    }
    return out;
  }

  void store(const Tile& tile, double value) const {
    for (int r = 0; r < tile.rows; ++r) std::fill_n(at(tile, r), tile.columns, value);
  }

  void store(const Tile& tile, const Means& means) const {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    for (int r = 0; r < tile.rows; ++r) {
      for (int c = 0; c < tile.columns; ++c) {
        const bool seen = plane_.at(tile.column + c, tile.row + r).z() > 0;
        at(tile, r)[c] = seen ? means[static_cast<std::size_t>(r * tile.columns + c)] : kNaN;
      }
    }
  }

  void converge(const Tile& tile, const TileTerms& terms, int first_parts, double enough_per_sr) const {
    Means last = means(tile, terms, gauss_nodes(2, first_parts));
    for (int parts = 2 * first_parts; parts <= kLargestParts; parts *= 2) {
      Means next = means(tile, terms, gauss_nodes(2, parts));
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
