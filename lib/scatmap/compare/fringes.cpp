#include "scatmap/compare/fringes.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "scatmap/compare/log_fit.h"

namespace scatmap {
namespace {

constexpr double kSigmas = 5;
constexpr double kDepth = 0.25;  // of the higher value
constexpr double kSummitPart = 0.6;

struct Smooth {
  std::size_t index;  // in the profile
  double value;
  double sigma;  // 0 without u_random
};

// (1 2 1)/4 over the finite samples.
std::vector<Smooth> smoothed(const Profile& p) {
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (std::isfinite(p.value_per_sr[i])) finite.push_back(i);
  }
  std::vector<Smooth> out;
  for (std::size_t k = 0; k < finite.size(); ++k) {
    const std::size_t a = finite[k > 0 ? k - 1 : k], b = finite[k], c = finite[std::min(k + 1, finite.size() - 1)];
    const auto mean = [&](const std::vector<double>& v) { return 0.25 * (v[a] + 2 * v[b] + v[c]); };
    // The standard deviation of one sample, not of the mean: bilinear neighbours share pixels.
    out.push_back({b, mean(p.value_per_sr), p.u_random_per_sr.empty() ? 0 : mean(p.u_random_per_sr)});
  }
  return out;
}

bool differ(const Smooth& high, const Smooth& low) {
  const double step = high.value - low.value;
  return step > kSigmas * std::hypot(high.sigma, low.sigma) && step > kDepth * std::abs(high.value);
}

double interpolated(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto upper = std::upper_bound(x.begin() + 1, x.end() - 1, at) - x.begin();
  const auto i = static_cast<std::size_t>(upper);
  return y[i - 1] + (y[i] - y[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1]);
}

struct Summit {
  double offset_px, height_per_sr, half_width_px;  // half width: down to kSummitPart
};

// exp(quadratic) through the finite samples within half_width_px of a place.
std::optional<Summit> fit_summit(const Profile& p, double at_px, double half_width_px) {
  const auto begin = std::lower_bound(p.offset_px.begin(), p.offset_px.end(), at_px - half_width_px);
  const auto end = std::upper_bound(begin, p.offset_px.end(), at_px + half_width_px);
  std::vector<double> x, value, sigma;
  for (auto o = begin; o != end; ++o) {
    const auto i = static_cast<std::size_t>(o - p.offset_px.begin());
    if (!std::isfinite(p.value_per_sr[i])) continue;
    x.push_back(*o - at_px);
    value.push_back(p.value_per_sr[i]);
    sigma.push_back(p.u_random_per_sr.empty() ? 1 : p.u_random_per_sr[i]);
  }
  const auto n = static_cast<Eigen::Index>(x.size());
  if (n < 4) return std::nullopt;
  Eigen::MatrixXd basis(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double xk = x[static_cast<std::size_t>(k)];
    basis.row(k) << 1, xk, xk * xk;
  }
  const auto fit =
      fit_log_linear(basis, Eigen::Map<Eigen::VectorXd>(value.data(), n), Eigen::Map<Eigen::VectorXd>(sigma.data(), n));
  if (!fit || !(fit->coefficients[2] < 0)) return std::nullopt;
  const Eigen::VectorXd& c = fit->coefficients;
  const double shift = -c[1] / (2 * c[2]);
  if (!(std::abs(shift) <= half_width_px)) return std::nullopt;
  return Summit{at_px + shift, std::exp(c[0] + 0.5 * c[1] * shift), std::sqrt(std::log(kSummitPart) / c[2])};
}

// The samples above kSummitPart tell where to begin; then the fit itself says which samples belong, because choosing
// them by their noisy values would raise the summit. The sample itself if there is no fit.
FringeMaximum summit(const Profile& p, const Smooth& top) {
  const auto belongs = [&](std::size_t i) { return p.value_per_sr[i] >= kSummitPart * top.value; };
  std::size_t first = top.index, last = top.index;
  while (first > 0 && belongs(first - 1)) --first;
  while (last + 1 < p.size() && belongs(last + 1)) ++last;
  const double start = (p.offset_px[first] + p.offset_px[last]) / 2;
  const double widest = std::max(2.0, p.offset_px[last] - p.offset_px[first]);
  std::optional<Summit> found = fit_summit(p, start, std::max(2.0, widest / 2));
  for (int pass = 0; found && pass < 3; ++pass) {
    found = fit_summit(p, found->offset_px, std::clamp(found->half_width_px, 2.0, widest));
  }
  if (!found) {
    return {.offset_px = p.offset_px[top.index], .angle_deg = p.angle_deg[top.index], .height_per_sr = top.value};
  }
  return {.offset_px = found->offset_px,
          .angle_deg = interpolated(p.offset_px, p.angle_deg, found->offset_px),
          .height_per_sr = found->height_per_sr};
}

// Beside a gap the highest sample need not be the summit: that may lie in the gap.
bool beside_a_gap(const Profile& p, std::size_t i) {
  for (std::size_t k = i < 2 ? 0 : i - 2; k <= std::min(i + 2, p.size() - 1); ++k) {
    if (!std::isfinite(p.value_per_sr[k])) return true;
  }
  return false;
}

struct Line {
  double slope, slope_sigma;
};

Line straight_line(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0, rest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += x[i] / n;
    mean_y += y[i] / n;
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  const double slope = xy / xx;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double r = y[i] - mean_y - slope * (x[i] - mean_x);
    rest += r * r;
  }
  return {slope, std::sqrt(rest / std::max(1.0, n - 2) / xx)};
}

// Smallest spacing that at least a third of the neighbours have: a missed fringe doubles a distance, never halves it.
double typical_spacing(const std::vector<FringeMaximum>& maxima) {
  std::vector<double> distance;
  for (std::size_t i = 1; i < maxima.size(); ++i) {
    const bool same_side = maxima[i].offset_px * maxima[i - 1].offset_px > 0;
    if (same_side && maxima[i].clear && maxima[i - 1].clear) {
      distance.push_back(maxima[i].offset_px - maxima[i - 1].offset_px);
    }
  }
  if (distance.empty()) return 0;
  std::sort(distance.begin(), distance.end());
  return distance[distance.size() / 3];
}

// Outwards from the centre, side by side: each order is the one before plus the distance in spacings, at least one.
void set_orders(std::vector<FringeMaximum>& maxima, double spacing_px) {
  const auto number = [&](auto first, auto last, int side) {
    double before = 0;
    int order = 0;
    for (auto m = first; m != last; ++m) {
      order += std::max(1, static_cast<int>(std::lround(std::abs(m->offset_px - before) / spacing_px)));
      before = m->offset_px;
      m->order = side * order;
    }
  };
  const auto centre = std::find_if(maxima.begin(), maxima.end(), [](const auto& m) { return m.offset_px > 0; });
  number(centre, maxima.end(), 1);
  number(std::make_reverse_iterator(centre), maxima.rend(), -1);
}

void describe(FringeComb& comb) {
  std::vector<double> order, offset, angle;
  for (const FringeMaximum& m : comb.maxima) {
    comb.orders_before = std::max(comb.orders_before, -m.order);
    comb.orders_after = std::max(comb.orders_after, m.order);
    if (!m.clear) continue;
    order.push_back(m.order);
    offset.push_back(m.offset_px);
    angle.push_back(m.angle_deg);
  }
  const Line px = straight_line(order, offset), deg = straight_line(order, angle);
  comb.spacing_px = px.slope;
  comb.spacing_sigma_px = px.slope_sigma;
  comb.spacing_deg = deg.slope;
  comb.spacing_sigma_deg = deg.slope_sigma;
  std::vector<double> first, last;
  const auto side = [&](auto begin, auto end) {
    const auto clear = std::find_if(begin, end, [](const auto& m) { return m.clear; });
    if (clear != end) first.push_back(clear->height_per_sr);
    if (begin != end) last.push_back(std::prev(end)->height_per_sr);
  };
  const auto centre = std::find_if(comb.maxima.begin(), comb.maxima.end(), [](const auto& m) { return m.order > 0; });
  side(centre, comb.maxima.end());
  side(std::make_reverse_iterator(centre), comb.maxima.rend());
  const auto mean = [](const std::vector<double>& v) { return v.size() == 2 ? (v[0] + v[1]) / 2 : v[0]; };
  comb.first_height_per_sr = mean(first);
  comb.last_height_per_sr = mean(last);
}

}  // namespace

std::vector<FringeMaximum> find_maxima(const Profile& profile) {
  std::vector<FringeMaximum> maxima;
  const std::vector<Smooth> samples = smoothed(profile);
  if (samples.empty()) return maxima;
  bool rising = false;
  Smooth extreme = samples.front();  // the lowest since the last summit, or the highest since the last valley
  for (const Smooth& s : samples) {
    if (rising) {
      if (s.value > extreme.value) extreme = s;
      if (!differ(extreme, s)) continue;
      if (!beside_a_gap(profile, extreme.index)) maxima.push_back(summit(profile, extreme));
    } else {
      if (s.value < extreme.value) extreme = s;
      if (!differ(s, extreme)) continue;
    }
    rising = !rising;
    extreme = s;
  }
  return maxima;
}

std::optional<FringeComb> find_fringes(const Profile& profile, double lobe_px) {
  FringeComb comb;
  comb.maxima = find_maxima(profile);
  for (FringeMaximum& m : comb.maxima) m.clear = std::abs(m.offset_px) > lobe_px;
  const double spacing = typical_spacing(comb.maxima);
  if (!(spacing > 0)) return std::nullopt;
  // What is nearer to the centre than half a spacing is order 0: the lobe itself, or the fringe under it.
  std::erase_if(comb.maxima, [&](const FringeMaximum& m) { return std::abs(m.offset_px) < 0.5 * spacing; });
  const auto clear = std::count_if(comb.maxima.begin(), comb.maxima.end(), [](const auto& m) { return m.clear; });
  if (clear < 3) return std::nullopt;
  set_orders(comb.maxima, spacing);
  describe(comb);
  return comb;
}

}  // namespace scatmap
