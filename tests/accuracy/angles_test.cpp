// Every method of the angle map within its stated bound in the eleven regimes where angles go wrong; about 2e5 pixels
// each (angles_slow_test: 1e7). Does not prove the bounds between the samples, nor on instruction sets other than the
// one this runs on (angle_kernel_test: the baseline).
#include "tests/accuracy/angles_expect.h"

namespace scatmap {
namespace {

class AnglesAccuracy : public testing::TestWithParam<std::size_t> {};

TEST_P(AnglesAccuracy, WithinBounds) {
  const long long samples = test::expect_within_bounds(GetParam(), test::angle_errors(GetParam(), 100, 200, 20261122));
  EXPECT_GE(samples, 3000);
}

INSTANTIATE_TEST_SUITE_P(Regimes, AnglesAccuracy, testing::Range<std::size_t>(0, test::kRegimes.size()));

}  // namespace
}  // namespace scatmap
