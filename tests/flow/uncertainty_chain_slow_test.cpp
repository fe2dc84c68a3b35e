// The same as uncertainty_chain_test.cpp with 2000 trials, to 3 %, which is less than two standard errors of the trials.
// By hand: ctest -L slow -R uncertainty_chain
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/flow/uncertainty_chain.h"

namespace scatmap {
namespace {

class UncertaintyChainSlow : public testing::TestWithParam<test::ChainCase> {};

TEST_P(UncertaintyChainSlow, ClaimsWithinThreePerCentAndThreeStandardErrors) {
  const auto first_seed = 100000 + 10000 * static_cast<unsigned>(GetParam());
  const test::ChainResult r = test::uncertainty_chain(GetParam(), 2000, first_seed);
  for (const auto& [what, claim] :
       {std::pair{"random", r.random}, {"structured", r.structured}, {"scale", r.scale}, {"region mean", r.region}}) {
    std::printf("%-11s claimed/observed %.4f (standard error %.4f), coverage %.4f of %.0f, mean %+.4f\n", what,
                claim.claimed_over_observed(), claim.standard_error(), claim.coverage(), claim.n, claim.sum / claim.n);
    EXPECT_NEAR(claim.claimed_over_observed(), 1, 0.03) << what;
    EXPECT_NEAR(claim.coverage(), 0.95, 3 * std::sqrt(0.95 * 0.05 / claim.n) + 0.002) << what;
  }
  std::printf("largest scale uncertainty %.4f, largest seam %.5f, ratio %.5f rms, notes %.0f\n", r.largest_u_scale,
              r.largest_seam, r.rms_ratio_error(), r.notes);
}

INSTANTIATE_TEST_SUITE_P(Cases, UncertaintyChainSlow,
                         testing::Values(test::ChainCase::kOneExposure, test::ChainCase::kThreeExposures,
                                         test::ChainCase::kPaperSameStack, test::ChainCase::kPaperSignatures));

}  // namespace
}  // namespace scatmap
