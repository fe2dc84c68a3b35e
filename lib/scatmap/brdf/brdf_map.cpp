#include "scatmap/brdf/brdf_map.h"

#include <cmath>

namespace scatmap {

Grid<float> per_pixel_uncertainty(const BrdfMap& map) {
  if (map.u_random_per_sr.empty() && map.u_pose_per_sr.empty() && map.structured.empty()) return {};
  std::vector<const Grid<float>*> parts;
  for (const Grid<float>* part : {&map.u_random_per_sr, &map.u_pose_per_sr}) {
    if (!part->empty()) parts.push_back(part);
  }
  for (const StructuredCause& s : map.structured) parts.push_back(&s.sensitivity_per_sr);
  Grid<float> out(map.mask.rows(), map.mask.columns());
  for (std::size_t i = 0; i < out.size(); ++i) {
    double sum = 0;
    for (const Grid<float>* part : parts) sum += static_cast<double>((*part)[i]) * (*part)[i];
    out[i] = static_cast<float>(std::sqrt(sum));
  }
  return out;
}

}  // namespace scatmap
