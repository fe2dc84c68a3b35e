// Killed at any time: the old output, or the new one whole; nothing left once the next output is written. SIGINT and
// SIGTERM: the same at once, within a second, and the process ends as by the signal. Proves it for the moments tried
// (kills_slow_test.cpp tries more), on this file system; not for a loss of power.
#include "faults/kills.h"

namespace scatmap::test {
namespace {

class Kill : public testing::TestWithParam<Writer> {
 protected:
  Kill() : lab_(maker_.fresh_copy()) { complete(lab_); }
  LabMaker maker_;
  Lab lab_;
  std::mt19937 random_{20210731};
};

TEST_P(Kill, LeavesTheOldOutputOrTheNewOneWhole) {
  const bool slow = GetParam().name == "pictures" || GetParam().name == "chart";
  kill_at_random(lab_, GetParam(), slow ? 5 : 16, SIGKILL, random_);
}

TEST_P(Kill, InterruptEndsWithinASecondAndTakesTemporariesAway) {
  constexpr double kLongest_s = 1;
  for (const int signal : {SIGINT, SIGTERM}) {
    const Kills kills = kill_at_random(lab_, GetParam(), 3, signal, random_);
    EXPECT_LT(kills.slowest_end_s, kLongest_s);
  }
}

INSTANTIATE_TEST_SUITE_P(Writers, Kill, testing::ValuesIn(writers()), [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace scatmap::test
