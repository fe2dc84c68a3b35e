#include "scatmap/model/frame_model.h"

#include <algorithm>
#include <cassert>

#include "scatmap/base/parallel.h"
#include "scatmap/model/culled.h"
#include "scatmap/model/pixel_average.h"

namespace scatmap {
namespace {

// Where the halving of tiles begins: small enough to share among threads, large enough that looking at it costs
// nothing.
constexpr int kTileRows = 64, kTileColumns = 256;

}  // namespace

FrameModel::FrameModel(const Model& model, const Vector3<double>& wi, double detector_distance_m,
                       const DirectionPlane& plane, int rows, int columns, const FrameModelOptions& options)
    : exact_(model, wi, detector_distance_m),
      kernel_(model, wi, detector_distance_m),
      plane_(plane),
      rows_(rows),
      columns_(columns),
      options_(options) {}

void FrameModel::fill(std::span<double> values) const {
  assert(values.size() == static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_));
  // A source below the horizon lights nothing: the rows' methods say so, tiles would bound what does not exist.
  if ((options_.method == ModelMethod::kCulled || options_.pixel_average) && kernel_.wi().z() > 0)
    return fill_tiles(values);
  fill_rows(values);
}

void FrameModel::fill_rows(std::span<double> values) const {
  for_each_row(rows_, [&](int row) {
    const auto width = static_cast<std::size_t>(columns_);
    const std::span<double> out = values.subspan(static_cast<std::size_t>(row) * width, width);
    if (options_.method == ModelMethod::kExact) {
      for (int c = 0; c < columns_; ++c) out[static_cast<std::size_t>(c)] = exact_(plane_.at(c, row).normalized());
    } else {
      kernel_.row(plane_, 0, row, options_.method == ModelMethod::kSingle ? Amplitudes::kSingle : Amplitudes::kDouble,
                  out);
    }
  });
}

void FrameModel::fill_tiles(std::span<double> values) const {
  const ModelTolerance tolerance{options_.tolerance_rel, peak_floor(kernel_, plane_, rows_, columns_)};
  const auto fill_tile = options_.pixel_average ? pixel_average_tile : culled_tile;
  const int down = (rows_ + kTileRows - 1) / kTileRows, across = (columns_ + kTileColumns - 1) / kTileColumns;
  for_each_index(down * across, 1, [&](int i) {
    const int row = i / across * kTileRows, column = i % across * kTileColumns;
    const Tile tile{column, row, std::min(kTileColumns, columns_ - column), std::min(kTileRows, rows_ - row)};
    fill_tile(kernel_, plane_, tolerance, tile, values.data(), static_cast<std::size_t>(columns_));
  });
}

}  // namespace scatmap
