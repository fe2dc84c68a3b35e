#include "scatmap/counts/expected_signal.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "scatmap/base/parallel.h"

namespace scatmap {
namespace {

constexpr int kReach = 2;

struct Sums {
  double value = 0, square = 0, count = 0;
};

// Sums over the window's rows, column by column, of the good pixels.
void column_sums(const Grid<double>& value, const Grid<Mask>& mask, int row, std::vector<Sums>& out) {
  std::fill(out.begin(), out.end(), Sums{});
  const int first = std::max(0, row - kReach), last = std::min(value.rows() - 1, row + kReach);
  for (int r = first; r <= last; ++r) {
    for (int c = 0; c < value.columns(); ++c) {
      const double v = value(r, c);
      if (mask(r, c) != 0 || !std::isfinite(v)) continue;
      Sums& s = out[static_cast<std::size_t>(c)];
      s.value += v;
      s.square += v * v;
      s.count += 1;
    }
  }
}

}  // namespace

Grid<double> expected_signal(const Grid<double>& value, const Grid<float>& floor, const Grid<float>& shot,
                             const Grid<Mask>& mask) {
  Grid<double> out(value.rows(), value.columns());
  for_row_ranges(value.rows(), [&](int first_row, int last_row) {
    std::vector<Sums> sums(static_cast<std::size_t>(value.columns()));
    for (int row = first_row; row < last_row; ++row) {
      column_sums(value, mask, row, sums);
      for (int c = 0; c < value.columns(); ++c) {
        Sums s;
        for (int k = std::max(0, c - kReach); k <= std::min(value.columns() - 1, c + kReach); ++k) {
          const Sums& column = sums[static_cast<std::size_t>(k)];
          s.value += column.value;
          s.square += column.square;
          s.count += column.count;
        }
        const double v = value(row, c);
        const bool good = mask(row, c) == 0 && std::isfinite(v);
        if (good) {
          s.value -= v;
          s.square -= v * v;
          s.count -= 1;
        }
        const double mean = s.value / s.count;
        if (!good || s.count < kLeastNeighbours) {
          out(row, c) = good ? v : mean;
          continue;
        }
        const double scatter = (s.square - s.value * mean) / (s.count - 1);
        const double noise = floor(row, c) + std::max(0.0, mean) * shot(row, c);
        // Scatter that chance explains is not structure: else half of all flat pixels would see their own fluctuation.
        const double by_chance = noise * (1 + kStructureSigmas * std::sqrt(2 / (s.count - 1)));
        const double structure = std::max(0.0, scatter - by_chance);
        out(row, c) = mean + (structure > 0 ? structure / (structure + noise) : 0) * (v - mean);
      }
    }
  });
  return out;
}

}  // namespace scatmap
