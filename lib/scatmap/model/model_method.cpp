#include "scatmap/model/model_method.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace scatmap {
namespace {

constexpr const char* kReference = "long double, separate formula";
constexpr const char* kDomain = "angles to 89 deg, m 1e-6 to 10, any n but the critical angle itself";
constexpr const char* kUnit = "relative, of the larger of value and 1e-6 of the peak";

constexpr std::array kBounds{
    MethodBound{"model", "exact", "BRDF", kReference, kDomain, kUnit, kExactModelError},
    MethodBound{"model", "vector", "BRDF", kReference, kDomain, kUnit, kVectorModelError},
    MethodBound{"model", "single", "BRDF", kReference, kDomain, kUnit, kSingleModelError},
    MethodBound{"model", "culled", "BRDF", kReference, "any frame; the bound is the tolerance asked for, from here on",
                kUnit, kSmallestCulledTolerance},
};

constexpr std::array<std::pair<ModelMethod, const char*>, 4> kNames{{{ModelMethod::kExact, "exact"},
                                                                     {ModelMethod::kVector, "vector"},
                                                                     {ModelMethod::kSingle, "single"},
                                                                     {ModelMethod::kCulled, "culled"}}};

// At 1e-6 of its peak a Gaussian's exponent is 13.8: it changes by twice its root per width.
const double kSlope = 2 * std::sqrt(std::log(1e6));

}  // namespace

double model_rounding_error(const Model& model, const Vector3<double>& wi, double detector_distance_m) {
  double amplification = 0;
  for (const Term& term : model.terms) {
    if (const auto* lobe = std::get_if<MicrofacetTerm>(&term)) {
      amplification = std::max(amplification, kSlope / lobe->m);
    } else if (const auto* stripes = std::get_if<StripesTerm>(&term)) {
      const double stretch = stripes->form == StripesForm::kPaper ? 2 * wi.z() : 2;
      const double phase_rad = std::numbers::pi * stretch * (stripes->a_m + stripes->b_m) / model.wavelength_m;
      amplification = std::max(amplification, kSlope * detector_distance_m / stripes->c_m + 2000 * phase_rad);
    }
  }
  return kDirectionRounding * amplification;
}

std::span<const MethodBound> model_method_bounds() { return kBounds; }

ModelMethod choose_model_method(double tolerance_rel) {
  if (tolerance_rel >= kSmallestCulledTolerance) return ModelMethod::kCulled;
  return tolerance_rel >= kVectorModelError ? ModelMethod::kVector : ModelMethod::kExact;
}

const char* model_method_name(ModelMethod method) {
  return std::find_if(kNames.begin(), kNames.end(), [&](const auto& n) { return n.first == method; })->second;
}

std::optional<ModelMethod> model_method_of(std::string_view name) {
  for (const auto& [method, text] : kNames) {
    if (name == text) return method;
  }
  return std::nullopt;
}

}  // namespace scatmap
