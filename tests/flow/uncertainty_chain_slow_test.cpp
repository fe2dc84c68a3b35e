// The same as uncertainty_chain_test.cpp to 3 %, with so many trials that this is at least three of their standard
// errors. By hand, some 30 minutes: ctest -L slow -R uncertainty_chain
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/flow/uncertainty_chain.h"

namespace scatmap {
namespace {

constexpr int kCoverageOf = 2000;  // coverage is asked for to three standard errors of as many trials

// A standard deviation is known to 0.6 % or 0.9 %. Where the pose is uncertain the gradient's own 1 % (see
// docs/uncertainty.md) leaves less room for chance.
int trials_of(test::ChainCase which) {
  return which == test::ChainCase::kOneExposure || which == test::ChainCase::kThreeExposures ? 12000 : 6000;
}

class UncertaintyChainSlow : public testing::TestWithParam<test::ChainCase> {};

TEST_P(UncertaintyChainSlow, ClaimsWithinThreePerCentAndThreeStandardErrors) {
  const auto first_seed = 100000 + 10000 * static_cast<unsigned>(GetParam());
  const int trials = trials_of(GetParam());
  const test::ChainResult r = test::uncertainty_chain(GetParam(), trials, first_seed);
  for (const auto& [what, claim] :
       {std::pair{"random", r.random}, {"structured", r.structured}, {"scale", r.scale}, {"region mean", r.region}}) {
    std::printf("%-11s claimed/observed %.4f (standard error %.4f), coverage %.4f of %.0f, mean %+.4f\n", what,
                claim.claimed_over_observed(), claim.standard_error(), claim.coverage(), claim.n, claim.sum / claim.n);
    EXPECT_NEAR(claim.claimed_over_observed(), 1, 0.03) << what;
    const double n = claim.n * kCoverageOf / trials;
    EXPECT_NEAR(claim.coverage(), 0.95, 3 * std::sqrt(0.95 * 0.05 / n) + 0.002) << what;
  }
  std::printf("largest scale uncertainty %.4f, largest seam %.5f, ratio %.5f rms, notes %.0f\n", r.largest_u_scale,
              r.largest_seam, r.rms_ratio_error(), r.notes);
}

INSTANTIATE_TEST_SUITE_P(Cases, UncertaintyChainSlow,
                         testing::Values(test::ChainCase::kOneExposure, test::ChainCase::kThreeExposures,
                                         test::ChainCase::kPaperSameStack, test::ChainCase::kPaperSignatures));

}  // namespace
}  // namespace scatmap
