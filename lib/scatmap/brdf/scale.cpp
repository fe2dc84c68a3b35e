#include "scatmap/brdf/scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "scatmap/base/units.h"

namespace scatmap {
namespace {

constexpr std::array<std::pair<Distribution, const char*>, 4> kNames{{{Distribution::kNormal, "normal"},
                                                                      {Distribution::kRectangular, "rectangular"},
                                                                      {Distribution::kTriangular, "triangular"},
                                                                      {Distribution::kAsymmetric, "asymmetric"}}};

// sqrt(Σ ρ_ij x_i x_j), x_i = ±size(cause), signed as the sensitivity.
template <class Size>
double correlated_sum(const ScaleBudget& b, bool filters_only, Size&& size) {
  double sum = 0;
  for (std::size_t i = 0; i < b.causes.size(); ++i) {
    for (std::size_t j = 0; j < b.causes.size(); ++j) {
      if (filters_only && !(b.causes[i].is_filter && b.causes[j].is_filter)) continue;
      const double rho = b.correlation_of(i, j);
      if (rho != 0)
        sum += rho * std::copysign(size(b.causes[i]), b.causes[i].sensitivity) *
               std::copysign(size(b.causes[j]), b.causes[j].sensitivity);
    }
  }
  return std::sqrt(std::max(0.0, sum));
}

}  // namespace

const char* to_string(Distribution d) {
  for (const auto& [value, name] : kNames) {
    if (value == d) return name;
  }
  return "";
}

std::optional<Distribution> distribution_from(const std::string& text) {
  for (const auto& [value, name] : kNames) {
    if (text == name) return value;
  }
  return std::nullopt;
}

double ScaleCause::standard() const {
  const double size = std::abs(sensitivity);
  switch (distribution) {
    case Distribution::kNormal:
      return size * half_width;
    case Distribution::kRectangular:
      return size * half_width / std::numbers::sqrt3;
    case Distribution::kTriangular:
      return size * half_width / std::sqrt(6.0);
    case Distribution::kAsymmetric:
      return size * (half_width + half_width_below) / std::sqrt(12.0);
  }
  return std::nan("");
}

double ScaleCause::worst_case() const {
  if (distribution == Distribution::kNormal) return std::numbers::sqrt3 * standard();
  return std::abs(sensitivity) * std::max(half_width, half_width_below);
}

double ScaleBudget::correlation_of(std::size_t a, std::size_t b) const {
  if (a == b) return 1;
  return correlation.size() == 0 ? 0 : correlation(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
}

double ScaleBudget::standard() const {
  return correlated_sum(*this, false, [](const ScaleCause& c) { return c.standard(); });
}

double ScaleBudget::filters_worst_case() const {
  return correlated_sum(*this, true, [](const ScaleCause& c) { return c.worst_case(); });
}

double ScaleBudget::filters_standard() const {
  return correlated_sum(*this, true, [](const ScaleCause& c) { return c.standard(); });
}

double ScaleBudget::filters_linear_bound() const {
  double sum = 0;
  for (const ScaleCause& c : causes) sum += c.is_filter ? c.worst_case() : 0;
  return sum;
}

ScaleInterval ScaleBudget::filters_interval() const {
  const double delta_ln = filters_worst_case();  // of ln f: δ·ln 10
  return {std::expm1(-delta_ln), std::expm1(delta_ln)};
}

}  // namespace scatmap
