#include "scatmap/compare/features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "scatmap/base/units.h"
#include "scatmap/compare/lobe.h"
#include "scatmap/compare/pixel_directions.h"

namespace scatmap {
namespace {

constexpr float kBad = std::numeric_limits<float>::quiet_NaN();
constexpr float kAboveBackground = 2;   // candidates stand this factor above the map's median
constexpr double kMinSignificance = 5;  // and this many standard deviations above zero
constexpr std::size_t kMaxCandidates = 20000;
constexpr float kValley = 0.5;  // of the lower lobe: what divides two lobes

struct Candidate {
  int row = 0;
  int column = 0;
  float height = 0;  // 3 × 3 median
};

Grid<float> good_values(const BrdfMap& map) {
  Grid<float> good(map.mask.rows(), map.mask.columns());
  for (int r = 0; r < good.rows(); ++r) {
    for (int c = 0; c < good.columns(); ++c) {
      good(r, c) = is_good(map, r, c) ? static_cast<float>(map.brdf_per_sr(r, c)) : kBad;
    }
  }
  return good;
}

// Of about 10^5 pixels spread over the map; 0 for a map without good pixels.
float background(const Grid<float>& good) {
  const std::size_t step = std::max<std::size_t>(1, good.size() / 100003);
  std::vector<float> sample;
  for (std::size_t i = 0; i < good.size(); i += step) {
    if (std::isfinite(good[i])) sample.push_back(good[i]);
  }
  if (sample.empty()) return 0;
  const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
  std::nth_element(sample.begin(), middle, sample.end());
  return *middle;
}

// No good neighbour is higher; of equal neighbours the first in storage order is the maximum.
bool is_maximum(const Grid<float>& good, int row, int column) {
  const float f = good(row, column);
  for (int dr = -1; dr <= 1; ++dr) {
    for (int dc = -1; dc <= 1; ++dc) {
      const int r = row + dr, c = column + dc;
      if ((dr == 0 && dc == 0) || r < 0 || c < 0 || r >= good.rows() || c >= good.columns()) continue;
      const bool before = dr < 0 || (dr == 0 && dc < 0);
      if (good(r, c) > f || (before && good(r, c) == f)) return false;
    }
  }
  return true;
}

float median_around(const Grid<float>& good, int row, int column) {
  std::array<float, 9> values{};
  std::size_t n = 0;
  for (int r = std::max(0, row - 1); r <= std::min(good.rows() - 1, row + 1); ++r) {
    for (int c = std::max(0, column - 1); c <= std::min(good.columns() - 1, column + 1); ++c) {
      if (std::isfinite(good(r, c))) values[n++] = good(r, c);
    }
  }
  if (n < 4) return kBad;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((n - 1) / 2);
  std::nth_element(values.begin(), middle, values.begin() + static_cast<std::ptrdiff_t>(n));
  return *middle;
}

std::vector<Candidate> candidates(const BrdfMap& map, const Grid<float>& good) {
  const float floor = std::max(0.0F, kAboveBackground * background(good));
  std::vector<Candidate> found;
  for (int r = 0; r < good.rows(); ++r) {
    for (int c = 0; c < good.columns(); ++c) {
      if (!(good(r, c) > floor) || !is_maximum(good, r, c)) continue;
      const float height = median_around(good, r, c);
      const bool significant =
          map.u_random_per_sr.empty() || good(r, c) > kMinSignificance * static_cast<double>(map.u_random_per_sr(r, c));
      if (height > floor && significant) found.push_back({r, c, height});
    }
  }
  std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) { return a.height > b.height; });
  if (found.size() > kMaxCandidates) found.resize(kMaxCandidates);
  return found;
}

// Whether the straight way between two maxima dips below kValley of the lower: mean of three steps, bad pixels passed
// over.
bool divided(const Grid<float>& good, const Candidate& a, const Candidate& b) {
  const int steps = std::max(std::abs(a.row - b.row), std::abs(a.column - b.column));
  const float valley = kValley * std::min(a.height, b.height);
  std::array<float, 3> last{};
  std::size_t seen = 0;
  for (int k = 0; k <= steps; ++k) {
    const double t = static_cast<double>(k) / std::max(1, steps);
    const float f = good(static_cast<int>(std::lround(a.row + t * (b.row - a.row))),
                         static_cast<int>(std::lround(a.column + t * (b.column - a.column))));
    if (!std::isfinite(f)) continue;
    last[seen++ % 3] = f;
    if (seen >= 3 && (last[0] + last[1] + last[2]) / 3 < valley) return true;
  }
  return false;
}

// The highest lobes, at most one more than there may be peaks.
std::vector<Candidate> lobes(const BrdfMap& map, const Grid<float>& good) {
  std::vector<Candidate> separate;
  for (const Candidate& c : candidates(map, good)) {
    const bool own = std::all_of(separate.begin(), separate.end(),
                                 [&](const Candidate& higher) { return divided(good, higher, c); });
    if (own) separate.push_back(c);
    if (separate.size() > kMaxPeaks) break;
  }
  return separate;
}

Peak make_peak(const Lobe& lobe, const PixelDirections& directions, double rival) {
  const Vector3<double> direction = directions(lobe.summit);
  Peak p;
  p.column_px = lobe.summit.column;
  p.row_px = lobe.summit.row;
  p.column_sigma_px = lobe.column_sigma_px;
  p.row_sigma_px = lobe.row_sigma_px;
  p.height_per_sr = lobe.height_per_sr;
  p.height_sigma_per_sr = lobe.height_sigma_per_sr;
  p.radius_px = lobe.radius_px;
  p.minor_radius_px = lobe.minor_radius_px;
  p.theta_s_deg = polar_angle(direction) * kDegPerRad;
  p.phi_s_deg = azimuth_from_minus_x(direction) * kDegPerRad;
  p.prominence = lobe.height_per_sr / rival;
  return p;
}

}  // namespace

std::vector<Peak> find_peaks(const BrdfMap& map) {
  const Grid<float> good = good_values(map);
  const std::vector<Candidate> found = lobes(map, good);
  // Below the last lobe lies the background, which no candidate is under.
  const double floor = std::max(kAboveBackground * background(good), std::numeric_limits<float>::min());
  const auto height = [&](std::size_t rank) {
    return rank < found.size() ? static_cast<double>(found[rank].height) : floor;
  };
  std::size_t count = std::min<std::size_t>(found.size(), kMaxPeaks);
  while (count > 0 && !(height(count - 1) >= kMinProminence * height(count))) --count;
  if (count == 0) return {};

  const PixelDirections directions(map);
  std::vector<Peak> peaks;
  for (std::size_t k = 0; k < count; ++k) {
    const auto lobe = fit_lobe(map, found[k].column, found[k].row, static_cast<double>(found[k].height));
    if (lobe) peaks.push_back(make_peak(*lobe, directions, height(count)));
  }
  std::sort(peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) { return a.height_per_sr > b.height_per_sr; });
  return peaks;
}

std::vector<PeakPair> pair_peaks(const std::vector<Peak>& measured, const std::vector<Peak>& modelled) {
  struct Link {
    std::size_t measured, modelled;
    double distance_px;
  };
  std::vector<Link> links;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    for (std::size_t j = 0; j < modelled.size(); ++j) {
      const double distance =
          std::hypot(measured[i].column_px - modelled[j].column_px, measured[i].row_px - modelled[j].row_px);
      links.push_back({i, j, distance});
    }
  }
  std::stable_sort(links.begin(), links.end(),
                   [](const Link& a, const Link& b) { return a.distance_px < b.distance_px; });
  std::vector<std::optional<std::size_t>> partner(measured.size());
  std::vector<bool> taken(modelled.size(), false);
  for (const Link& l : links) {
    if (partner[l.measured] || taken[l.modelled]) continue;
    partner[l.measured] = l.modelled;
    taken[l.modelled] = true;
  }
  std::vector<PeakPair> pairs;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!partner[i]) continue;
    const Peak &a = measured[i], &b = modelled[*partner[i]];
    const auto direction = [](const Peak& p) {
      return direction_from_angles(p.theta_s_deg * kRadPerDeg, p.phi_s_deg * kRadPerDeg);
    };
    pairs.push_back({a, b, std::hypot(a.column_px - b.column_px, a.row_px - b.row_px),
                     angle_between<double>(direction(a), direction(b)) * kDegPerRad,
                     a.height_per_sr / b.height_per_sr});
  }
  return pairs;
}

}  // namespace scatmap
