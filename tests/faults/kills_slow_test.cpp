// As kills_test.cpp, 200 kills for every writer.
#include "faults/kills.h"

namespace scatmap::test {
namespace {

TEST(KillSlow, TwoHundredForEachWriter) {
  const LabMaker maker;
  std::mt19937 random(std::random_device{}());
  for (const Writer& w : writers()) {
    Lab lab = maker.fresh_copy();
    complete(lab);
    int killed = 0;
    while (killed < 200 && !HasFailure()) killed += kill_at_random(lab, w, 220 - killed, SIGKILL, random).killed;
    EXPECT_GE(killed, 200) << w.name;
  }
}

}  // namespace
}  // namespace scatmap::test
