#include "scatmap/brdf/signature.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/base/huge_page_allocator.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/parallel.h"
#include "scatmap/brdf/map_rows.h"

namespace scatmap {
namespace {

struct Circle {
  double column, row, radius;
};

bool good(const Counts& c, int row, int column) { return c.mask(row, column) == 0; }

bool is_inside(const Circle& circle, int row, int column) {
  const double dy = row - circle.row, dx = column - circle.column;
  return dx * dx + dy * dy <= circle.radius * circle.radius;
}

template <class Visit>
void for_each_inside(const Counts& c, const Circle& circle, int stride, Visit&& visit) {
  const int r0 = std::max(0, static_cast<int>(std::floor(circle.row - circle.radius)));
  const int r1 = std::min(c.mask.rows() - 1, static_cast<int>(std::ceil(circle.row + circle.radius)));
  const int c0 = std::max(0, static_cast<int>(std::floor(circle.column - circle.radius)));
  const int c1 = std::min(c.mask.columns() - 1, static_cast<int>(std::ceil(circle.column + circle.radius)));
  for (int r = r0; r <= r1; r += stride) {
    for (int k = c0; k <= c1; k += stride) {
      if (is_inside(circle, r, k)) visit(r, k);
    }
  }
}

// Mean of the good pixels among the eight neighbours.
std::optional<double> neighbour_mean(const Counts& c, int row, int column) {
  double sum = 0;
  int n = 0;
  for (int r = std::max(0, row - 1); r <= std::min(c.mask.rows() - 1, row + 1); ++r) {
    for (int k = std::max(0, column - 1); k <= std::min(c.mask.columns() - 1, column + 1); ++k) {
      if (!good(c, r, k) || (r == row && k == column)) continue;
      sum += c.rate_dn_per_s(r, k);
      ++n;
    }
  }
  if (n == 0) return std::nullopt;
  return sum / n;
}

// A hot pixel may saturate in any frame; anything else that saturates is light.
void refuse_saturation(const Counts& c) {
  std::vector<Mask> of_row(static_cast<std::size_t>(c.mask.rows()));
  for_each_row(c.mask.rows(), [&](int r) {
    Mask any = 0;
    for (const Mask m : c.mask.row(r)) any |= m;
    of_row[static_cast<std::size_t>(r)] = any;
  });
  for (int r = 0; r < c.mask.rows(); ++r) {
    if ((of_row[static_cast<std::size_t>(r)] & kSaturated) == 0) continue;
    for (int k = 0; k < c.mask.columns(); ++k) {
      const Mask m = c.mask(r, k);
      if ((m & kSaturated) == 0 || (m & (kHot | kBad)) != 0) continue;
      throw Error({"signature",
                   "is saturated at column " + std::to_string(k) + ", row " + std::to_string(r),
                   {},
                   "a shorter exposure or more filters"});
    }
  }
}

// Sums of three rows, column by column; beyond the frame's sides zero.
struct ColumnSums {
  std::vector<double> rate, count;
  explicit ColumnSums(int columns) : rate(static_cast<std::size_t>(columns) + 2), count(rate.size()) {}

  void fill(const Counts& c, int row) {
    std::fill(rate.begin(), rate.end(), 0.0);
    std::fill(count.begin(), count.end(), 0.0);
    for (int r = std::max(0, row - 1); r <= std::min(c.mask.rows() - 1, row + 1); ++r)
      add_good(c.rate_dn_per_s.row(r).data(), c.mask.row(r).data(), c.mask.columns(), &rate[1], &count[1]);
  }
  // Of the good pixels among one and its eight neighbours.
  double mean(std::size_t k) const {
    return (rate[k] + rate[k + 1] + rate[k + 2]) / (count[k] + count[k + 1] + count[k + 2]);
  }
};

constexpr double kStandsOut = 20;  // sigmas of a mean of nine pixels

// Brightest 3 × 3 mean.
Circle brightest(const Counts& c) {
  const int rows = c.mask.rows(), columns = c.mask.columns();
  std::vector<double> peaks(static_cast<std::size_t>(rows));
  for_row_ranges(rows, [&](int first, int last) {
    ColumnSums sums(columns);
    for (int r = first; r < last; ++r) {
      sums.fill(c, r);
      peaks[static_cast<std::size_t>(r)] = largest_mean_of_three(sums.rate.data(), sums.count.data(), columns);
    }
  });
  const auto highest = std::max_element(peaks.begin(), peaks.end());
  const int row = static_cast<int>(highest - peaks.begin());
  ColumnSums sums(columns);
  sums.fill(c, row);
  int column = 0;
  while (column + 1 < columns && !(sums.mean(static_cast<std::size_t>(column)) >= *highest)) ++column;
  if (!(*highest > kStandsOut * std::sqrt(c.variance(row, column, 0) / 9)))
    throw Error({"signature", "shows no beam: its brightest spot does not stand out of the noise", {}, {}});
  return {static_cast<double>(column), static_cast<double>(row), 3};
}

struct Ring {
  double level = 0;
  double u_level = 0;
};

// Clipped mean in the ring around the aperture; what else is in the frame (another spot) is clipped away.
// @param most  pixels, spread over the ring
Ring background(const Counts& c, const Circle& circle, double most) {
  const Circle outer{circle.column, circle.row, background_radius_px(circle.radius)};
  std::vector<double, HugePageAllocator<double>> values;  // a large ring has millions
  const double area = std::min(4 * outer.radius * outer.radius, static_cast<double>(c.mask.size()));
  const int stride = static_cast<int>(std::max(1.0, std::sqrt(area / most)));
  values.reserve(static_cast<std::size_t>(std::min(area, most)) + 64);
  double noise = 0;
  for_each_inside(c, outer, stride, [&](int r, int k) {
    if (!good(c, r, k) || is_inside(circle, r, k)) return;
    values.push_back(c.rate_dn_per_s(r, k));
    noise += c.variance(r, k, 0);
  });
  if (values.size() < 20) throw Error({"signature", "leaves no room for a background ring around the beam", {}, {}});
  noise = std::sqrt(noise / static_cast<double>(values.size()));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  const double median = values[values.size() / 2];
  double sum = 0, square = 0, n = 0;
  for (const double v : values) {
    if (!(std::abs(v - median) <= 6 * noise + 0.5 * std::abs(median))) continue;
    sum += v - median;
    square += (v - median) * (v - median);
    n += 1;
  }
  const double mean = sum / n;
  return {median + mean, std::sqrt(std::max(0.0, square / n - mean * mean) / n)};
}

// Centroid and aperture from first and second moments inside the present aperture, background removed.
Circle moments(const Counts& c, const Circle& circle, double level) {
  double sum = 0, x = 0, y = 0, xx = 0, yy = 0;
  for_each_inside(c, circle, 1, [&](int r, int k) {
    if (!good(c, r, k)) return;
    const double v = c.rate_dn_per_s(r, k) - level, dx = k - circle.column, dy = r - circle.row;
    sum += v;
    x += v * dx;
    y += v * dy;
    xx += v * dx * dx;
    yy += v * dy * dy;
  });
  if (!(sum > 0)) throw Error({"signature", "shows no beam above its background", {}, {}});
  x /= sum;
  y /= sum;
  const double variance = std::max({0.25, xx / sum - x * x, yy / sum - y * y});
  return {circle.column + x, circle.row + y, kApertureBeamRadii * 2 * std::sqrt(variance)};
}

Circle find_aperture(const Counts& c, std::optional<double> radius_px) {
  Circle circle = brightest(c);
  if (radius_px) circle.radius = *radius_px;
  for (int i = 0; i < 60; ++i) {
    constexpr double kEnough = 1e5;  // while the aperture is looked for
    const Circle next = moments(c, circle, background(c, circle, kEnough).level);
    const double change =
        std::abs(next.radius - circle.radius) + std::hypot(next.column - circle.column, next.row - circle.row);
    // Grown by at most a half at a time, so that a neighbour spot is not swallowed before the beam has been measured.
    circle = {next.column, next.row, radius_px ? *radius_px : std::min(next.radius, 1.5 * circle.radius)};
    if (change < 0.01) break;
  }
  return circle;
}

}  // namespace

Signature measure_signature(const Counts& c, std::optional<double> radius_px) {
  refuse_saturation(c);
  const Circle circle = find_aperture(c, radius_px);
  if (!(circle.column - circle.radius >= 0 && circle.column + circle.radius <= c.mask.columns() - 1 &&
        circle.row - circle.radius >= 0 && circle.row + circle.radius <= c.mask.rows() - 1)) {
    throw Error({"signature", "its beam is cut off by the frame's edge",
                 "an aperture of radius " + number_text(std::round(circle.radius)) + " px",
                 "the whole beam on the detector"});
  }
  const Ring ring = background(c, circle, HUGE_VAL);
  Signature out{0, 0, circle.column, circle.row, circle.radius, ring.level, 0, 0};
  double variance = 0, square = 0, pixels = 0;
  for_each_inside(c, circle, 1, [&](int r, int k) {
    double rate = c.rate_dn_per_s(r, k);
    if (!good(c, r, k)) {
      const auto mean = neighbour_mean(c, r, k);
      if (!mean) throw Error({"signature", "has a cluster of bad pixels inside the beam", {}, {}});
      variance +=
          (*mean - ring.level) * (*mean - ring.level) / 16;  // a neighbour mean is good to a quarter of the value
      rate = *mean;
      ++out.replaced_pixels;
    }
    const double net = rate - ring.level;
    out.rate_dn_per_s += net;
    square += net * net;
    variance += c.variance(r, k, rate);
    pixels += 1;
  });
  variance += pixels * pixels * ring.u_level * ring.u_level;
  out.u_rate_dn_per_s = std::sqrt(variance);
  out.effective_rate = square / out.rate_dn_per_s;
  if (!(out.rate_dn_per_s > 0))
    throw Error({"signature", "sums to nothing", number_text(out.rate_dn_per_s) + " DN/s", "more than 0"});
  return out;
}

namespace {

// Columns of a row that lie left and right of a circle.
std::vector<std::pair<int, int>> beside(const Circle& circle, int row, int columns) {
  const double across2 = circle.radius * circle.radius - (row - circle.row) * (row - circle.row);
  if (!(across2 > 0)) return {{0, columns}};
  const double half = std::sqrt(across2);
  const int left = static_cast<int>(std::floor(circle.column - half)),
            right = static_cast<int>(std::ceil(circle.column + half));
  return {{0, std::clamp(left, 0, columns)}, {std::clamp(right + 1, 0, columns), columns}};
}

// Whether more than one pixel of the nine is bright: a hit is none.
bool is_spread(const Counts& c, int row, int column, double half) {
  int bright = 0;
  for (int r = std::max(0, row - 1); r <= std::min(c.mask.rows() - 1, row + 1); ++r) {
    for (int k = std::max(0, column - 1); k <= std::min(c.mask.columns() - 1, column + 1); ++k)
      bright += good(c, r, k) && c.rate_dn_per_s(r, k) > half ? 1 : 0;
  }
  return bright >= 3;
}

}  // namespace

std::optional<OtherSpot> other_spot(const Counts& c, const Signature& beam) {
  const Circle ring{beam.column, beam.row, background_radius_px(beam.radius_px)};
  const int rows = c.mask.rows(), columns = c.mask.columns();
  std::vector<double> peaks(static_cast<std::size_t>(rows), -HUGE_VAL);
  for_row_ranges(rows, [&](int first, int last) {
    ColumnSums sums(columns);
    for (int r = first; r < last; ++r) {
      sums.fill(c, r);
      for (const auto& [from, to] : beside(ring, r, columns)) {
        double& peak = peaks[static_cast<std::size_t>(r)];
        peak = std::max(peak, largest_mean_of_three(sums.rate.data() + from, sums.count.data() + from, to - from));
      }
    }
  });
  const auto highest = std::max_element(peaks.begin(), peaks.end());
  const int row = static_cast<int>(highest - peaks.begin());
  const double above = *highest - beam.background_dn_per_s, share = above / (2 * beam.effective_rate);
  if (!(share > kLeastOtherSpot)) return std::nullopt;
  ColumnSums sums(columns);
  sums.fill(c, row);
  for (const auto& [from, to] : beside(ring, row, columns)) {
    for (int k = from; k < to; ++k) {
      if (!(sums.mean(static_cast<std::size_t>(k)) >= *highest)) continue;
      if (!(above > kStandsOut * std::sqrt(c.variance(row, k, 0) / 9)) ||
          !is_spread(c, row, k, beam.background_dn_per_s + above / 2))
        return std::nullopt;
      return OtherSpot{static_cast<double>(k), static_cast<double>(row), share};
    }
  }
  return std::nullopt;
}

}  // namespace scatmap
