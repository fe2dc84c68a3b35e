#pragma once
#include <optional>
#include <span>
#include <string_view>

#include "scatmap/base/direction.h"
#include "scatmap/base/method_bound.h"
#include "scatmap/model/model.h"

namespace scatmap {

/// How a model is evaluated over a frame. Errors are relative to the larger of the value and kPeakShare (1e-6) of the
/// largest value in the frame.
enum class ModelMethod {
  kExact,   ///< PreparedModel, pixel by pixel: libm, double
  kVector,  ///< ModelKernel: rows of pixels in vector registers, double
  kSingle,  ///< the same with amplitudes in float; directions, exponents and phases stay double
  kCulled,  ///< tiles in which terms that cannot matter are left out or interpolated, to a given tolerance
};

/// Bounds for directions given as doubles; what their own rounding adds is model_rounding_error(). Domain of both:
/// angles of incidence and scattering up to 89 degrees, m from 1e-6 to 10, n from 1 + 1e-6 to metals; for total
/// reflection (n < 1) no closer to the critical angle than 1e-6 in sin².
inline constexpr double kExactModelError = 1e-12;
inline constexpr double kVectorModelError = 1e-12;
inline constexpr double kSingleModelError = 2e-5;
/// `culled` keeps any tolerance from here on.
inline constexpr double kSmallestCulledTolerance = 1e-11;
/// What the tool asks for if nobody says otherwise: far below what files in single precision keep (6e-8).
inline constexpr double kDefaultModelTolerance = 1e-9;

/// Error that the rounding of directions to double alone causes, whatever the method: that of a unit vector is
/// kDirectionRounding, and a lobe m wide or a pattern of many fringes magnifies it by 7.4/m (at 1e-6 of the peak) or,
/// beside the zeros of cos², by 2000 times the phase in rad. `phase_rad` beyond that of the frame's edge is harmless.
double model_rounding_error(const Model& model, const Vector3<double>& wi, double detector_distance_m);
inline constexpr double kDirectionRounding = 5e-16;

/// The rows above, for `scatmap chart`, tests and docs.
std::span<const MethodBound> model_method_bounds();

/// The cheapest method within `tolerance_rel` (> 0); `exact` if none is.
ModelMethod choose_model_method(double tolerance_rel);

/// As --method takes it.
const char* model_method_name(ModelMethod method);
std::optional<ModelMethod> model_method_of(std::string_view name);

}  // namespace scatmap
