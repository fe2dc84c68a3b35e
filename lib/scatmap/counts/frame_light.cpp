#include "scatmap/counts/frame_light.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "scatmap/base/parallel.h"
#include "scatmap/counts/row_kernels.h"

namespace scatmap {

FrameLight frame_light(const Grid<float>& dn) {
  const int rows = dn.rows(), columns = dn.columns();
  std::vector<RowLight> of_row(static_cast<std::size_t>(rows));
  for_each_row(rows, [&](int r) { of_row[static_cast<std::size_t>(r)] = row_light(dn.row(r).data(), columns); });
  FrameLight out;
  float largest = -std::numeric_limits<float>::infinity();
  for (const RowLight& row : of_row) {
    out.sum_dn += row.sum;
    largest = std::max(largest, row.largest);
  }
  if (!(largest > -std::numeric_limits<float>::infinity())) return out;
  out.largest_dn = largest;
  for (int r = 0; r < rows; ++r) {
    if (of_row[static_cast<std::size_t>(r)].largest < largest) continue;
    const auto row = dn.row(r);
    out.at_largest += static_cast<std::size_t>(std::count(row.begin(), row.end(), largest));
  }
  return out;
}

}  // namespace scatmap
