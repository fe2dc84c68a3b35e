#include "scatmap/brdf/brdf_map.h"

#include "scatmap/base/parallel.h"
#include "scatmap/brdf/map_rows.h"

namespace scatmap {

std::vector<const Grid<float>*> uncertainty_parts(const BrdfMap& map) {
  std::vector<const Grid<float>*> parts;
  for (const Grid<float>* part : {&map.u_random_per_sr, &map.u_pose_per_sr}) {
    if (!part->empty()) parts.push_back(part);
  }
  for (const StructuredCause& s : map.structured) parts.push_back(&s.sensitivity_per_sr);
  return parts;
}

void per_pixel_uncertainty_row(std::span<const Grid<float>* const> parts, int row, std::span<float> out) {
  std::vector<const float*> rows;
  for (const Grid<float>* part : parts) rows.push_back(part->row(row).data());
  norm_of_rows(rows, static_cast<int>(out.size()), out.data());
}

Grid<float> per_pixel_uncertainty(const BrdfMap& map) {
  const std::vector<const Grid<float>*> parts = uncertainty_parts(map);
  if (parts.empty()) return {};
  Grid<float> out(map.mask.rows(), map.mask.columns());
  for_each_row(out.rows(), [&](int row) { per_pixel_uncertainty_row(parts, row, out.row(row)); });
  return out;
}

}  // namespace scatmap
