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
/// and corners, horizons through the frame, several terms of very different size. Every pixel's `culled` value against
/// the `vector` one, and some against long double truth on the plane's own vectors.
struct CullingErrors {
  double largest_of_allowed = 0;  ///< against `vector`, in units of tolerance and rounding
  double largest_of_allowed_truth = 0;
  long pixels = 0;
  long truths = 0;
  std::string where, where_truth;
};
CullingErrors measure_culling(int frames, unsigned long seed);

/// Pixel averages on such frames, with features no narrower than a third of a pixel, against long double quadrature of
/// 64 × 64 points in each of some pixels: the largest part of the tolerance used.
MethodErrors measure_averages(int frames, unsigned long seed);

}  // namespace scatmap::accuracy
