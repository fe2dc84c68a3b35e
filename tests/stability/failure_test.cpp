// A cell that FAILS ends `chart stability` by an Error, which main turns into exit status 1 (tests/cli). Does not prove
// that a wrong number is judged so: that is each job's verdict (tools/chart/stability_*.cpp).
#include <gtest/gtest.h>

#include "scatmap/base/error.h"
#include "tools/chart/stability.h"

namespace scatmap::tools {
namespace {

StabilityCell cell(const char* regime, Verdict verdict) {
  StabilityCell c;
  c.job = "angles";
  c.regime = regime;
  c.method = "exact";
  c.verdict = verdict;
  return c;
}

TEST(StabilityFailure, OtherVerdictsPass) {
  EXPECT_NO_THROW(require_no_failure({}));
  EXPECT_NO_THROW(require_no_failure({cell("a", Verdict::kHolds), cell("b", Verdict::kIllConditioned),
                                      cell("c", Verdict::kFallsBack), cell("d", Verdict::kRefuses)}));
}

TEST(StabilityFailure, OneFailureAmongManyIsAnErrorThatNamesIt) {
  try {
    require_no_failure({cell("a", Verdict::kHolds), cell("the pole", Verdict::kFails), cell("c", Verdict::kFails)});
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "stability: 2 FAILS (stability.csv), the first: angles, the pole, exact");
  }
}

TEST(StabilityFailure, ACellThatNobodyJudgedFails) { EXPECT_THROW(require_no_failure({StabilityCell{}}), Error); }

}  // namespace
}  // namespace scatmap::tools
