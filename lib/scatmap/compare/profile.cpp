#include "scatmap/compare/profile.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "scatmap/compare/lobe.h"
#include "scatmap/compare/pixel_directions.h"

namespace scatmap {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

bool on_map(const BrdfMap& map, PixelPosition at) {
  return at.column >= 0 && at.row >= 0 && at.column <= map.mask.columns() - 1 && at.row <= map.mask.rows() - 1;
}

void require_on_map(const BrdfMap& map, PixelPosition origin) {
  if (on_map(map, {std::round(origin.column), std::round(origin.row)})) return;
  throw Error(
      {"profile", "starts off the map",
       "column " + std::to_string(origin.column) + ", row " + std::to_string(origin.row),
       "a pixel of " + std::to_string(map.mask.columns()) + " columns × " + std::to_string(map.mask.rows()) + " rows"});
}

double distance_px(PixelPosition a, PixelPosition b) { return std::hypot(a.column - b.column, a.row - b.row); }

// Path lengths from the sample nearest the origin.
std::vector<double> path_offsets(const std::vector<PixelPosition>& path, PixelPosition origin) {
  std::vector<double> length(path.size(), 0.0);
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    length[i] = length[i - 1] + distance_px(path[i], path[i - 1]);
    if (distance_px(path[i], origin) < distance_px(path[nearest], origin)) nearest = i;
  }
  const double zero = length[nearest];
  for (double& l : length) l -= zero;
  return length;
}

}  // namespace

Sample sample_map(const BrdfMap& map, PixelPosition at) {
  if (!on_map(map, at)) return {kNaN, kNaN};
  const int c0 = static_cast<int>(std::floor(at.column)), r0 = static_cast<int>(std::floor(at.row));
  const double x = at.column - c0, y = at.row - r0;
  double value = 0, variance = map.u_random_per_sr.empty() ? kNaN : 0;
  for (int dr = 0; dr < 2; ++dr) {
    for (int dc = 0; dc < 2; ++dc) {
      const double share = (dc ? x : 1 - x) * (dr ? y : 1 - y);
      if (share == 0) continue;
      if (!is_good(map, r0 + dr, c0 + dc)) return {kNaN, kNaN};
      value += share * map.brdf_per_sr(r0 + dr, c0 + dc);
      if (!map.u_random_per_sr.empty()) {
        const double u = share * static_cast<double>(map.u_random_per_sr(r0 + dr, c0 + dc));
        variance += u * u;
      }
    }
  }
  return {value, std::sqrt(variance)};
}

Profile path_profile(const BrdfMap& map, PixelPosition origin, std::vector<PixelPosition> path) {
  if (path.empty()) throw Error({"profile", "its line does not cross the map", {}, {}});
  const PixelDirections directions(map);
  Profile p;
  p.offset_px = path_offsets(path, origin);
  p.position = std::move(path);
  const Vector3<double> from = directions(origin);
  for (std::size_t i = 0; i < p.position.size(); ++i) {
    const PixelPosition at = p.position[i];
    const double angle = angle_between<double>(from, directions(at)) * kDegPerRad;
    p.angle_deg.push_back(std::copysign(angle, p.offset_px[i]));
    const Sample s = sample_map(map, at);
    p.value_per_sr.push_back(s.value_per_sr);
    if (!map.u_random_per_sr.empty()) p.u_random_per_sr.push_back(s.u_random_per_sr);
  }
  return p;
}

Profile column_profile(const BrdfMap& map, PixelPosition origin) {
  require_on_map(map, origin);
  std::vector<PixelPosition> path;
  const double column = std::round(origin.column);
  for (int r = 0; r < map.mask.rows(); ++r) path.push_back({column, static_cast<double>(r)});
  return path_profile(map, {column, std::round(origin.row)}, std::move(path));
}

Profile row_profile(const BrdfMap& map, PixelPosition origin) {
  require_on_map(map, origin);
  std::vector<PixelPosition> path;
  const double row = std::round(origin.row);
  for (int c = 0; c < map.mask.columns(); ++c) path.push_back({static_cast<double>(c), row});
  return path_profile(map, {std::round(origin.column), row}, std::move(path));
}

Profile line_profile(const BrdfMap& map, PixelPosition origin, double axis_deg) {
  require_on_map(map, origin);
  const double along_column = std::cos(axis_deg * kRadPerDeg), along_row = std::sin(axis_deg * kRadPerDeg);
  const int reach = map.mask.columns() + map.mask.rows();
  std::vector<PixelPosition> path;
  for (int s = -reach; s <= reach; ++s) {
    const PixelPosition at{origin.column + s * along_column, origin.row + s * along_row};
    if (on_map(map, at)) path.push_back(at);
  }
  return path_profile(map, origin, std::move(path));
}

}  // namespace scatmap
