#pragma once
#include <optional>

#include "scatmap/base/progress.h"
#include "scatmap/brdf/brdf_map.h"
#include "scatmap/brdf/measurement.h"
#include "scatmap/brdf/overlap.h"
#include "scatmap/brdf/signature_exposures.h"

namespace scatmap {

/// Which optical densities (and exposure times) several exposures are merged with.
enum class FilterValues {
  kByOverlap,  ///< measured from pixels good in two exposures, the stated values as priors
  kNominal     ///< as stated
};

/// How counts become BRDF; both give the same map within fused.h's bounds.
enum class BrdfMethod {
  kFused,  ///< one pass over the frames (fused.h); several exposures are merged first, and are always exact
  kExact   ///< step by step with whole intermediate images: the reference
};

/// What the overlaps of several exposures said.
struct OverlapReport {
  ExposureCauses causes;
  OverlapSolution solution;
};

/// A finished map and what was found on the way.
struct BrdfResult {
  BrdfMap map;
  Signature signature;                      ///< in DN/s as the first of its exposures shows it
  std::vector<double> signature_share;      ///< of each signature exposure in the beam's sum
  std::vector<ScaleBudget> exposure_scale;  ///< one per exposure, as stated: its ND stack against the signature's
  std::optional<OverlapReport> overlap;     ///< absent with nominal filters or nothing to measure
};

/// Reads the frames of a measurement and turns raw counts into BRDF (docs/conventions.md, measurement equation):
///   f = [(S − D)/(t T)] / [Σ (S0 − D0)/(t0 T0)] / (Ω cos theta_s).
/// Several exposures are merged, the sample's and the signature's. A cause that acts alike on all exposures goes to the
/// scale; one that does not moves pixels by their share of the exposure and becomes a structured cause; with overlap
/// see split_causes.h.
/// @throws Error for anything wrong with a file, naming it
BrdfResult brdf_from_frames(const Measurement& measurement, const Progress& progress = {},
                            FilterValues filters = FilterValues::kByOverlap, BrdfMethod method = BrdfMethod::kFused);

}  // namespace scatmap
