#include "scatmap/counts/frame_light.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "scatmap/base/parallel.h"
#include "scatmap/counts/row_kernels.h"

namespace scatmap {

namespace {

// @param row_of  (row, buffer) to the row's values, which may stand in the buffer
template <class RowOf>
FrameLight light_of(int rows, int columns, const RowOf& row_of) {
  std::vector<RowLight> of_row(static_cast<std::size_t>(rows));
  for_row_ranges(rows, [&](int first, int last) {
    std::vector<float> buffer(static_cast<std::size_t>(columns));
    for (int r = first; r < last; ++r)
      of_row[static_cast<std::size_t>(r)] = row_light(row_of(r, buffer.data()), columns);
  });
  FrameLight out;
  float largest = -std::numeric_limits<float>::infinity();
  for (const RowLight& row : of_row) {
    out.sum_dn += row.sum;
    largest = std::max(largest, row.largest);
  }
  if (!(largest > -std::numeric_limits<float>::infinity())) return out;
  out.largest_dn = largest;
  std::vector<float> buffer(static_cast<std::size_t>(columns));
  for (int r = 0; r < rows; ++r) {
    if (of_row[static_cast<std::size_t>(r)].largest < largest) continue;
    const float* row = row_of(r, buffer.data());
    out.at_largest += static_cast<std::size_t>(std::count(row, row + columns, largest));
  }
  return out;
}

}  // namespace

FrameLight frame_light(const Grid<float>& dn) {
  return light_of(dn.rows(), dn.columns(), [&](int r, float*) { return dn.row(r).data(); });
}

FrameLight frame_light(const RawCounts& dn) {
  return light_of(dn.rows(), dn.columns(), [&](int r, float* buffer) { return dn.part(r, 0, dn.columns(), buffer); });
}

}  // namespace scatmap
