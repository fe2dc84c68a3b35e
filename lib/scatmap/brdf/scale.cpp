#include "scatmap/brdf/scale.h"

#include <cmath>
#include <numbers>

#include "scatmap/base/units.h"

namespace scatmap {

const char* to_string(Distribution d) { return d == Distribution::kNormal ? "normal" : "rectangular"; }

double ScaleCause::standard() const {
  return std::abs(sensitivity) * half_width / (distribution == Distribution::kRectangular ? std::numbers::sqrt3 : 1);
}

double ScaleCause::worst_case() const { return std::numbers::sqrt3 * standard(); }

double ScaleBudget::standard() const {
  double sum = 0;
  for (const ScaleCause& c : causes) sum += c.standard() * c.standard();
  return std::sqrt(sum);
}

double ScaleBudget::filters_worst_case() const {
  double sum = 0;
  for (const ScaleCause& c : causes) sum += c.is_filter ? c.worst_case() * c.worst_case() : 0;
  return std::sqrt(sum);
}

double ScaleBudget::filters_standard() const { return filters_worst_case() / std::numbers::sqrt3; }

ScaleInterval ScaleBudget::filters_interval() const {
  const double delta_ln = filters_worst_case();  // of ln f: δ·ln 10
  return {std::expm1(-delta_ln), std::expm1(delta_ln)};
}

}  // namespace scatmap
