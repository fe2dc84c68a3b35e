#pragma once
#include "scatmap/brdf/scale_statistics.h"

namespace scatmap::tools {

/// Probability that F = exp(Σ sensitivity_i X_i)·(1 + r Z) lies in an interval, without drawing a number: the sum of
/// the rectangular causes has a distribution in closed form (long double, inclusion and exclusion over its 2^n
/// corners), the normal ones are integrated over. For rectangular and normal, independent causes; up to 12 rectangular
/// ones.
double probability_within(const ScaleBudget& budget, double relative_normal, const FactorInterval& interval);

}  // namespace scatmap::tools
