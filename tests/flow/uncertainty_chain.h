#pragma once
#include "tests/flow/chain_scene.h"

/// The whole chain, scene → raw frames → BRDF, with every source drawn from the distribution that the lab states:
/// filters and laser (rectangular), exposure times (normal), pose (from the calibration's covariance), non-linearity
/// (rectangular), photons and read noise. Claimed against observed.
namespace scatmap::test {

/// Of one quantity over all trials: z = error/claimed standard uncertainty.
struct Claim {
  double n = 0, sum = 0, square = 0, fourth = 0, covered = 0;
  void add(double z, bool inside);
  double claimed_over_observed() const;  ///< of standard deviations about the truth
  double standard_error() const;         ///< of that, from the observed fourth moment
  double coverage() const { return covered / n; }
};

struct ChainResult {
  Claim random;      ///< pixels against their neighbours: nothing common is left
  Claim structured;  ///< ratio of the two flanks of the lobe: the scale cancels, the pose does not
  Claim scale;       ///< power in the whole lobe; coverage of the 95 % Monte Carlo interval
  Claim region;      ///< mean over a faint region, where random and common parts are of one size
  double largest_u_scale = 0;
  double largest_seam = 0;  ///< beyond three standard uncertainties of the pair, of overlaps that were used
  double ratio_square = 0;  ///< sum of the squared relative errors of the ratio
  double rms_ratio_error() const;
  double first_order_fails = 0;  ///< share of trials in which clause 8 says that first order fails
  double trials = 0, notes = 0;
};

ChainResult uncertainty_chain(ChainCase which, int trials, unsigned first_seed);

}  // namespace scatmap::test
