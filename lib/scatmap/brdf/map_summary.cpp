#include "scatmap/brdf/map_summary.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "scatmap/base/parallel.h"
#include "scatmap/brdf/map_rows.h"

namespace scatmap {

MapSummary summarise(const BrdfMap& map) {
  const int columns = map.mask.columns();
  std::vector<RowSummary> rows(static_cast<std::size_t>(map.mask.rows()));
  const std::vector<const Grid<float>*> parts = uncertainty_parts(map);
  for_row_ranges(map.mask.rows(), [&](int first, int last) {
    std::vector<float> u(static_cast<std::size_t>(columns));
    for (int r = first; r < last; ++r) {
      per_pixel_uncertainty_row(parts, r, u);
      rows[static_cast<std::size_t>(r)] =
          summarise_row(map.brdf_per_sr.row(r).data(), u.data(), map.mask.row(r).data(), columns);
    }
  });
  MapSummary out;
  double sum = 0, count = 0;
  for (const RowSummary& row : rows) {
    out.good += static_cast<std::size_t>(row.good);
    out.largest = std::max(out.largest, row.largest);
    sum += row.sum;
    count += row.count;
  }
  out.mean_relative = count > 0 ? sum / count : std::nan("");
  return out;
}

}  // namespace scatmap
