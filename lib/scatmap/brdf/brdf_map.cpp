#include "scatmap/brdf/brdf_map.h"

#include <cmath>

#include "scatmap/base/parallel.h"

namespace scatmap {

Grid<float> per_pixel_uncertainty(const BrdfMap& map) {
  if (map.u_random_per_sr.empty() && map.u_pose_per_sr.empty() && map.structured.empty()) return {};
  std::vector<const Grid<float>*> parts;
  for (const Grid<float>* part : {&map.u_random_per_sr, &map.u_pose_per_sr}) {
    if (!part->empty()) parts.push_back(part);
  }
  for (const StructuredCause& s : map.structured) parts.push_back(&s.sensitivity_per_sr);
  Grid<float> out(map.mask.rows(), map.mask.columns());
  for_each_row(out.rows(), [&](int row) {
    std::vector<double> sum(static_cast<std::size_t>(out.columns()), 0.0);
    for (const Grid<float>* part : parts) {
      const std::span<const float> u = part->row(row);
      for (std::size_t c = 0; c < u.size(); ++c) sum[c] += static_cast<double>(u[c]) * u[c];
    }
    for (std::size_t c = 0; c < sum.size(); ++c) out.row(row)[c] = static_cast<float>(std::sqrt(sum[c]));
  });
  return out;
}

}  // namespace scatmap
