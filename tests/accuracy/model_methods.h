#pragma once
#include "accuracy/model_regimes.h"
#include "scatmap/model/model_method.h"

namespace scatmap::accuracy {

/// Errors of one method over one regime, in units of what is allowed: its bound and, where directions' rounding enters,
/// model_rounding_error().
struct MethodErrors {
  double largest_of_allowed = 0;
  double largest = 0;  ///< relative error where that was
  std::string where;
  long samples = 0;
};

struct RegimeErrors {
  MethodErrors exact, vector, single;
};

/// `cases` models with `directions` each, on directions given as doubles.
RegimeErrors measure_regime(Regime regime, int cases, int directions, unsigned long seed);

/// Random flat detectors whose tiles are set up against the culling: lobes and fringes between samples, at tile edges
/// and corners, horizons through the frame, several terms of very different size. Counts pixels whose `culled` value
/// differs from the `vector` one by more than the tolerance and rounding, and the largest part of the tolerance used.
struct CullingErrors {
  double largest_of_allowed = 0;
  long pixels = 0;
  std::string where;
};
CullingErrors measure_culling(int frames, unsigned long seed);

}  // namespace scatmap::accuracy
