#include "scatmap/compare/band.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>

#include "scatmap/base/units.h"
#include "scatmap/compare/lobe.h"
#include "scatmap/compare/pixel_directions.h"

namespace scatmap {
namespace {

constexpr double kLobeRadii = 3.5;      // around a peak the lobe outshines the band: e^−12
constexpr double kDynamicRange = 1e-5;  // of the lowest peak: fainter pixels tell no direction
constexpr double kClip = 4;             // e-folds above the floor at which a pixel's weight stops growing
constexpr double kMinConcentration = 0.5;
constexpr int kBlocks = 24;             // of the background along the longer side: a block is wider than twice the band
constexpr int kBins = 40;               // along the longer side; a comb of 52 fringes has more than one in each
constexpr double kRim = 0.8;            // of the window across the band: beyond it lies background
constexpr double kMinSignificance = 5;  // of a bin's centroid

struct Spread {
  double median = 0;
  double deviation = 0;  // 1.4826 × median absolute deviation
};

// Median and spread of blocks of the map: wide halos around the peaks are background, the narrow band is not.
class Background {
 public:
  explicit Background(const BrdfMap& map)
      : block_(std::max(16, (std::max(map.mask.rows(), map.mask.columns()) + kBlocks - 1) / kBlocks)),
        spread_((map.mask.rows() + block_ - 1) / block_, (map.mask.columns() + block_ - 1) / block_) {
    for (int r = 0; r < spread_.rows(); ++r) {
      for (int c = 0; c < spread_.columns(); ++c) spread_(r, c) = spread_of_block(map, r * block_, c * block_);
    }
  }
  const Spread& at(int row, int column) const { return spread_(row / block_, column / block_); }

 private:
  Spread spread_of_block(const BrdfMap& map, int row, int column) const {
    std::vector<double> values;
    for (int r = row; r < std::min(row + block_, map.mask.rows()); ++r) {
      for (int c = column; c < std::min(column + block_, map.mask.columns()); ++c) {
        if (is_good(map, r, c)) values.push_back(map.brdf_per_sr(r, c));
      }
    }
    if (values.empty()) return {};
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    const double median = *middle;
    for (double& v : values) v = std::abs(v - median);
    std::nth_element(values.begin(), middle, values.end());
    return {median, 1.4826 * *middle};
  }

  int block_;
  Grid<Spread> spread_;
};

bool under_a_lobe(const std::vector<Peak>& peaks, double column, double row) {
  return std::any_of(peaks.begin(), peaks.end(), [&](const Peak& p) {
    return std::hypot(column - p.column_px, row - p.row_px) < kLobeRadii * p.radius_px;
  });
}

// To the nearest edge, so that pixels on both sides of the peak count alike and a bend does not turn the axis.
double moment_radius(const BrdfMap& map, const Peak& p) {
  const double edge =
      std::min({p.column_px, p.row_px, map.mask.columns() - 1 - p.column_px, map.mask.rows() - 1 - p.row_px});
  return std::max(edge, 0.25 * std::min(map.mask.columns(), map.mask.rows()));
}

struct Moments {
  std::complex<double> sum;  // Σ weight · e^{2iα}
  double weight = 0;
};

Moments moments_about(const BrdfMap& map, const std::vector<Peak>& peaks, const Peak& centre,
                      const Background& background, double faintest) {
  const double radius = moment_radius(map, centre);
  const auto first = [](double x) { return std::max(0, static_cast<int>(std::ceil(x))); };
  const int last_row = std::min(map.mask.rows() - 1, static_cast<int>(centre.row_px + radius));
  const int last_column = std::min(map.mask.columns() - 1, static_cast<int>(centre.column_px + radius));
  Moments m;
  for (int r = first(centre.row_px - radius); r <= last_row; ++r) {
    for (int c = first(centre.column_px - radius); c <= last_column; ++c) {
      const Spread& local = background.at(r, c);
      const double floor = std::max({local.median + 5 * local.deviation, 2 * local.median, faintest});
      if (!(map.brdf_per_sr(r, c) > floor) || !is_good(map, r, c)) continue;
      const std::complex<double> d(c - centre.column_px, r - centre.row_px);
      if (std::norm(d) > radius * radius || under_a_lobe(peaks, c, r)) continue;
      const double weight = std::min(kClip, std::log(map.brdf_per_sr(r, c) / floor));
      m.sum += weight * d * d / std::norm(d);
      m.weight += weight;
    }
  }
  return m;
}

struct Step {
  double column, row;
};
Step unit(double axis_deg) { return {std::cos(axis_deg * kRadPerDeg), std::sin(axis_deg * kRadPerDeg)}; }

PixelPosition place(PixelPosition centre, Step along, double s, double e) {
  return {centre.column + s * along.column - e * along.row, centre.row + s * along.row + e * along.column};
}

struct RidgePoint {
  double along_px = 0;
  double across_px = 0;
  double significance = 0;
  double variance_px2 = 0;  // second moment across about the ridge
};

struct CrossSums {
  double value = 0, first_moment = 0, second_moment = 0, variance = 0;
};

// Moments across the band about a guess, above the level at the window's rims. Samples enter in pairs, one on each
// side: where a lobe, a mask or the map's edge takes one of them, the centroid must not move to the other.
CrossSums sum_across(const BrdfMap& map, const std::vector<Peak>& peaks, const Band& band, double first_px,
                     double last_px, double guess_px, double window_px) {
  const Step along = unit(band.chord_deg);
  CrossSums sums;
  double samples = 0, squares = 0, rim = 0, rim_samples = 0;
  for (double s = first_px; s < last_px; s += 1) {
    for (double e = 0.5; e <= window_px; e += 1) {
      const PixelPosition low = place(band.centre, along, s, guess_px - e);
      const PixelPosition high = place(band.centre, along, s, guess_px + e);
      if (under_a_lobe(peaks, low.column, low.row) || under_a_lobe(peaks, high.column, high.row)) continue;
      const Sample a = sample_map(map, low), b = sample_map(map, high);
      if (std::isnan(a.value_per_sr) || std::isnan(b.value_per_sr)) continue;
      const double both = a.value_per_sr + b.value_per_sr;
      sums.value += both;
      sums.first_moment += e * (b.value_per_sr - a.value_per_sr);
      sums.second_moment += e * e * both;
      samples += 2;
      squares += 2 * e * e;
      if (e > kRim * window_px) {
        rim += both;
        rim_samples += 2;
      }
      if (map.u_random_per_sr.empty()) continue;
      sums.variance += a.u_random_per_sr * a.u_random_per_sr + b.u_random_per_sr * b.u_random_per_sr;
    }
  }
  const double level = rim_samples > 0 ? rim / rim_samples : 0;
  sums.value -= level * samples;
  sums.second_moment -= level * squares;
  return sums;
}

// Centroid across the band between two distances along it, in a window around a guess that follows the centroid.
std::optional<RidgePoint> ridge_point(const BrdfMap& map, const std::vector<Peak>& peaks, const Band& band,
                                      double first_px, double last_px, double guess_px, double window_px) {
  std::optional<RidgePoint> point;
  for (int pass = 0; pass < 4; ++pass) {
    const CrossSums s = sum_across(map, peaks, band, first_px, last_px, guess_px, window_px);
    const double significance = s.variance > 0 ? s.value / std::sqrt(s.variance) : (s.value > 0 ? 1e3 : 0);
    const double shift = s.first_moment / s.value;
    if (!(significance > kMinSignificance) || !(std::abs(shift) < window_px)) return std::nullopt;
    guess_px += shift;
    point = {(first_px + last_px) / 2, guess_px, significance, s.second_moment / s.value - shift * shift};
  }
  return point;
}

std::vector<RidgePoint> follow(const BrdfMap& map, const std::vector<Peak>& peaks, const Band& band, double window_px) {
  const double bin = std::max(map.mask.rows(), map.mask.columns()) / static_cast<double>(kBins);
  std::vector<RidgePoint> ridge;
  for (const int side : {-1, 1}) {
    double guess = 0, slope = 0;
    for (int k = 0; k < kBins; ++k) {
      const double near = side * k * bin, far = side * (k + 1) * bin;
      const auto p = ridge_point(map, peaks, band, std::min(near, far), std::max(near, far), guess + slope, window_px);
      if (!p) continue;
      slope = k > 0 ? std::clamp(p->across_px - guess, -0.5 * window_px, 0.5 * window_px) : 0;
      guess = p->across_px;
      ridge.push_back(*p);
    }
  }
  return ridge;
}

// Weighted polynomial through the ridge points; a point much more significant than the rest must not rule.
void fit_bend(const std::vector<RidgePoint>& ridge, Band& band) {
  const Eigen::Index terms = ridge.size() >= 12 ? 5 : (ridge.size() >= 6 ? 3 : 2);
  const auto n = static_cast<Eigen::Index>(ridge.size());
  Eigen::MatrixXd basis(n, terms);
  Eigen::VectorXd across(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const RidgePoint& p = ridge[static_cast<std::size_t>(i)];
    const double weight = std::min(p.significance, 50.0);
    for (Eigen::Index k = 0; k < terms; ++k) {
      basis(i, k) = weight * std::pow(p.along_px / band.length_px, static_cast<double>(k));
    }
    across(i) = weight * p.across_px;
  }
  const Eigen::VectorXd c = basis.colPivHouseholderQr().solve(across);
  std::copy(c.begin(), c.end(), band.bend.begin());
}

double typical_radius(const std::vector<RidgePoint>& ridge) {
  std::vector<double> variance;
  for (const RidgePoint& p : ridge) variance.push_back(p.variance_px2);
  const auto middle = variance.begin() + static_cast<std::ptrdiff_t>(variance.size() / 2);
  std::nth_element(variance.begin(), middle, variance.end());
  return std::sqrt(2 * std::max(0.5, *middle));
}

// In [−45, 135), so that neither a vertical nor a horizontal band lies at the seam.
double fold_axis(double axis_deg) { return axis_deg - 180 * std::floor((axis_deg + 45) / 180); }

double direction_in_hemisphere(const BrdfMap& map, const Band& band) {
  const PixelDirections directions(map);
  const Step step = unit(band.axis_deg);
  const Vector3<double> d = directions(band.centre).normalized();
  const Vector3<double> tangent = directions.change(band.centre, step.column, step.row);
  const Vector3<double> out_of_plane = d.cross(Vector3<double>::UnitX()).normalized();
  return fold_axis(std::atan2(tangent.dot(out_of_plane), tangent.dot(out_of_plane.cross(d))) * kDegPerRad);
}

// The peak about which the bright pixels are most aligned, and their direction.
std::optional<Band> straight_band(const BrdfMap& map, const std::vector<Peak>& peaks, const Background& background,
                                  std::optional<double> axis_deg) {
  const double faintest = kDynamicRange * peaks.back().height_per_sr;
  Band band;
  double best = 0;
  for (std::size_t k = 0; k < peaks.size(); ++k) {
    const Moments m = moments_about(map, peaks, peaks[k], background, faintest);
    const double aligned = axis_deg ? std::real(m.sum * std::polar(1.0, -2 * *axis_deg * kRadPerDeg)) : std::abs(m.sum);
    const double per_length = aligned / moment_radius(map, peaks[k]);
    if (!(per_length > best)) continue;
    best = per_length;
    band.peak = k;
    band.centre = peaks[k].position();
    band.concentration = aligned / m.weight;
    band.chord_deg = axis_deg ? *axis_deg : fold_axis(std::arg(m.sum) / 2 * kDegPerRad);
  }
  if (!(best > 0) || !(band.concentration > kMinConcentration)) return std::nullopt;
  return band;
}

}  // namespace

PixelPosition Band::at(double along_px) const {
  const double t = std::clamp(along_px, first_px, last_px) / length_px;
  const double slope = bend[1] + t * (2 * bend[2] + t * (3 * bend[3] + t * 4 * bend[4]));
  const double across =
      bend[0] + t * (bend[1] + t * (bend[2] + t * (bend[3] + t * bend[4]))) + slope * (along_px / length_px - t);
  return place(centre, unit(chord_deg), along_px, across);
}

std::optional<Band> find_band(const BrdfMap& map, const std::vector<Peak>& peaks, std::optional<double> axis_deg) {
  if (peaks.empty()) return std::nullopt;
  const Background background(map);
  std::optional<Band> found = straight_band(map, peaks, background, axis_deg);
  if (!found) return std::nullopt;
  Band& band = *found;
  band.length_px = 0.5 * std::hypot(map.mask.columns(), map.mask.rows());
  const double widest = std::max(8.0, 0.03 * std::min(map.mask.columns(), map.mask.rows()));
  std::vector<RidgePoint> ridge = follow(map, peaks, band, widest);
  if (ridge.size() < 3) return std::nullopt;
  ridge = follow(map, peaks, band, std::clamp(2.5 * typical_radius(ridge), 3.0, widest));
  if (ridge.size() < 3) return std::nullopt;
  fit_bend(ridge, band);
  for (const RidgePoint& p : ridge) {
    band.first_px = std::min(band.first_px, p.along_px);
    band.last_px = std::max(band.last_px, p.along_px);
  }
  band.radius_px = typical_radius(ridge);
  band.axis_deg = fold_axis(band.chord_deg + std::atan(band.bend[1] / band.length_px) * kDegPerRad);
  band.direction_deg = direction_in_hemisphere(map, band);
  return found;
}

Profile ridge_profile(const BrdfMap& map, const Band& band) {
  const int reach = map.mask.columns() + map.mask.rows();
  std::vector<PixelPosition> path;
  for (int s = -reach; s <= reach; ++s) {
    const PixelPosition at = band.at(s);
    if (at.column >= 0 && at.row >= 0 && at.column <= map.mask.columns() - 1 && at.row <= map.mask.rows() - 1) {
      path.push_back(at);
    }
  }
  return path_profile(map, band.centre, std::move(path));
}

}  // namespace scatmap
