#include "scatmap/brdf/map_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "scatmap/brdf/pose_uncertainty.h"
#include "scatmap/counts/expected_signal.h"

namespace scatmap {
namespace {

bool is_pixel(const Region& r) { return r.first_column == r.last_column && r.first_row == r.last_row; }

std::string text_of(const Region& r) {
  const std::string first = std::to_string(r.first_column) + "," + std::to_string(r.first_row);
  return is_pixel(r) ? first : first + "," + std::to_string(r.last_column) + "," + std::to_string(r.last_row);
}

template <class Weight>
PixelSum sum_over(const BrdfMap& map, const Region& r, Weight&& weight) {
  const int rows = map.mask.rows(), columns = map.mask.columns();
  const char* const kind = is_pixel(r) ? "pixel" : "region";
  if (!(r.first_column >= 0 && r.first_row >= 0 && r.last_column >= r.first_column && r.last_row >= r.first_row &&
        r.last_column < columns && r.last_row < rows)) {
    throw Error({kind, "is not inside the map", text_of(r), "within " + text_of({0, 0, columns - 1, rows - 1})});
  }
  PixelSum out;
  for (int row = r.first_row; row <= r.last_row; ++row) {
    for (int c = r.first_column; c <= r.last_column; ++c) {
      if (map.mask(row, c) != 0) continue;
      out.pixels.push_back(static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                           static_cast<std::size_t>(c));
      out.weights.push_back(weight(row, c));
    }
  }
  if (out.pixels.empty()) {
    const int flags = map.mask(r.first_row, r.first_column);
    throw Error({kind, is_pixel(r) ? "is not good" : "holds no good pixel",
                 "mask " + std::to_string(flags) + (is_pixel(r) ? "" : " at its first"),
                 "a pixel of mask 0 (flags: docs/files.md)"});
  }
  return out;
}

Grid<double> smoothed(const BrdfMap& map) {
  Grid<float> variance(map.mask.rows(), map.mask.columns());
  for (std::size_t i = 0; i < variance.size(); ++i) variance[i] = map.u_random_per_sr[i] * map.u_random_per_sr[i];
  Grid<double> out =
      expected_signal(map.brdf_per_sr, variance, Grid<float>(variance.rows(), variance.columns(), 0.0f), map.mask);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (map.mask[i] != 0) out[i] = std::nan("");  // as when the map was made
  }
  return out;
}

}  // namespace

PixelSum mean_over(const BrdfMap& map, const Region& region) {
  PixelSum out = sum_over(map, region, [](int, int) { return 1.0; });
  for (double& w : out.weights) w /= static_cast<double>(out.pixels.size());
  return out;
}

PixelSum power_in(const BrdfMap& map, const Region& region) {
  return sum_over(map, region, [&](int row, int c) {
    return map.angles.solid_angle_sr(row, c) * std::cos(map.angles.theta_s_rad(row, c));
  });
}

double SumUncertainty::structured_total() const {
  double sum = 0;
  for (const CauseAmount& c : structured) sum += c.amount * c.amount;
  return std::sqrt(sum);
}

double SumUncertainty::without_scale() const { return std::hypot(random, structured_total()); }

double SumUncertainty::total() const { return std::hypot(without_scale(), value * scale_relative); }

double SumUncertainty::relative_without_scale() const { return without_scale() / std::abs(value); }

double SumUncertainty::relative_additive() const {
  double sum = random * random;
  for (const CauseAmount& c : structured) sum += c.is_pose ? c.amount * c.amount : 0;
  return std::sqrt(sum) / std::abs(value);
}

ScaleBudget factor_budget(const SumUncertainty& u, const ScaleBudget& scale) {
  ScaleBudget out = scale;
  for (const CauseAmount& c : u.structured) {
    constexpr double kNegligible = 1e-7;  // of the value: another exposure's filter
    if (c.is_pose || !(std::abs(c.amount) > kNegligible * std::abs(u.value))) continue;
    ScaleCause cause = c.cause;
    cause.sensitivity = 1;
    const double standard = cause.standard();
    if (!(standard > 0)) continue;
    cause.sensitivity = c.amount / u.value / standard;
    out.causes.push_back(std::move(cause));
  }
  if (out.correlation.size() == 0) return out;
  const auto size = static_cast<Eigen::Index>(out.causes.size()), before = out.correlation.rows();
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(size, size);
  correlation.topLeftCorner(before, before) = out.correlation;
  out.correlation = correlation;
  return out;
}

MapUncertainty::MapUncertainty(const BrdfMap& map) : map_(map) {
  if (map.u_random_per_sr.empty()) throw Error({"map", "has no uncertainties", "a modelled map", "a measured one"});
  if (!map.u_pose_per_sr.empty()) smooth_ = smoothed(map);
}

SumUncertainty MapUncertainty::of(const PixelSum& sum) const {
  SumUncertainty out;
  out.scale_relative = map_.scale.standard();
  for (const StructuredCause& s : map_.structured) out.structured.push_back({s.name, s.meaning, 0, s.cause, false});
  double variance = 0;
  for (std::size_t k = 0; k < sum.pixels.size(); ++k) {
    const std::size_t i = sum.pixels[k];
    const double w = sum.weights[k], u = map_.u_random_per_sr[i];
    out.value += w * map_.brdf_per_sr[i];
    variance += w * w * u * u;
    for (std::size_t c = 0; c < map_.structured.size(); ++c)
      out.structured[c].amount += w * map_.structured[c].sensitivity_per_sr[i];
  }
  out.random = std::sqrt(variance);
  if (map_.u_pose_per_sr.empty() || !map_.instrument.calibration) return out;
  const PoseSensitivities pose(map_.instrument, map_.pose, smooth_);
  std::vector<double> changes(pose.count()), amounts(pose.count(), 0);
  const auto columns = static_cast<std::size_t>(map_.mask.columns());
  for (std::size_t k = 0; k < sum.pixels.size(); ++k) {
    const std::size_t i = sum.pixels[k];
    pose.at(static_cast<int>(i / columns), static_cast<int>(i % columns), changes);
    const double norm = std::sqrt(std::inner_product(changes.begin(), changes.end(), changes.begin(), 0.0));
    const double to_map = norm > 0 ? map_.u_pose_per_sr[i] / norm : 0;
    for (std::size_t j = 0; j < amounts.size(); ++j) amounts[j] += sum.weights[k] * changes[j] * to_map;
  }
  for (std::size_t j = 0; j < amounts.size(); ++j) {
    out.structured.push_back(
        {"pose direction " + std::to_string(j + 1), "independent direction of the calibration covariance", amounts[j]});
    out.structured.back().is_pose = true;
  }
  return out;
}

double MapUncertainty::covariance(const PixelSum& a, const PixelSum& b) const {
  const SumUncertainty ua = of(a), ub = of(b);
  double out = ua.value * ub.value * ua.scale_relative * ua.scale_relative;
  for (std::size_t c = 0; c < ua.structured.size(); ++c) out += ua.structured[c].amount * ub.structured[c].amount;
  for (std::size_t i = 0, j = 0; i < a.pixels.size() && j < b.pixels.size();) {
    if (a.pixels[i] == b.pixels[j]) {
      const double u = map_.u_random_per_sr[a.pixels[i]];
      out += a.weights[i++] * b.weights[j++] * u * u;
    } else {
      a.pixels[i] < b.pixels[j] ? ++i : ++j;
    }
  }
  return out;
}

Ratio ratio_of(const MapUncertainty& u, const PixelSum& a, const PixelSum& b) {
  const SumUncertainty ua = u.of(a), ub = u.of(b);
  const double covariance = u.covariance(a, b);
  const double relative2 =
      std::pow(ua.total() / ua.value, 2) + std::pow(ub.total() / ub.value, 2) - 2 * covariance / (ua.value * ub.value);
  return {ua.value / ub.value, std::abs(ua.value / ub.value) * std::sqrt(std::max(0.0, relative2)),
          covariance / (ua.total() * ub.total())};
}

std::vector<FilterTarget> filter_targets(const ScaleBudget& budget, double other, double target) {
  std::vector<std::size_t> filters;
  for (std::size_t k = 0; k < budget.causes.size(); ++k) {
    if (budget.causes[k].is_filter && budget.causes[k].standard() > 0) filters.push_back(k);
  }
  std::sort(filters.begin(), filters.end(),
            [&](std::size_t a, std::size_t b) { return budget.causes[a].standard() > budget.causes[b].standard(); });
  ScaleBudget rest = budget;
  std::vector<FilterTarget> out;
  FilterTarget next;
  double sensitivity2 = 0;
  for (const std::size_t k : filters) {
    sensitivity2 += std::pow(budget.causes[k].sensitivity, 2);
    rest.causes[k].sensitivity = 0;
    next.filters.push_back(budget.causes[k].name);
    const double room = target * target - other * other - std::pow(rest.standard(), 2);
    next.u_od = room > 0 ? std::optional<double>(std::sqrt(room / sensitivity2)) : std::nullopt;
    out.push_back(next);
  }
  return out;
}

}  // namespace scatmap
