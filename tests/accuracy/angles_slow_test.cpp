// As angles_test with 1e6 pixels per method and regime, more than 1e7 per method. The same limits of proof hold.
#include "tests/accuracy/angles_expect.h"

namespace scatmap {
namespace {

class AnglesAccuracySlow : public testing::TestWithParam<std::size_t> {};

TEST_P(AnglesAccuracySlow, WithinBounds) {
  const long long samples = test::expect_within_bounds(GetParam(), test::angle_errors(GetParam(), 3000, 700, 7));
  EXPECT_GE(samples, 900000);
}

INSTANTIATE_TEST_SUITE_P(Regimes, AnglesAccuracySlow, testing::Range<std::size_t>(0, test::kRegimes.size()));

}  // namespace
}  // namespace scatmap
