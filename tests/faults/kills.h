#pragma once
#include <random>
#include <thread>

#include "faults/writers.h"

namespace scatmap::test {

/// What came of a number of killed runs.
struct Kills {
  int killed = 0;    ///< before the run was over
  int finished = 0;  ///< the run was over first
  int old = 0;       ///< the old output was there afterwards
  int whole = 0;     ///< the new one was
  double slowest_end_s = 0;
};

/// Sends `signal` at random times within the run, `count` times, and holds what is there afterwards to: the old output,
/// byte for byte, or the new one whole; and nothing else once another output was written there.
inline Kills kill_at_random(Lab& lab, const Writer& w, int count, int signal, std::mt19937& random) {
  put_old(lab, w);
  const Content old = content(lab, w);
  const auto begin = Clock::now();
  const ToolRun first = RunningTool(w.command, lab.folder()).wait();
  EXPECT_EQ(first.status, 0) << w.name << ": " << first.err;
  double run_s = seconds_since(begin);
  const Content whole = content(lab, w);
  EXPECT_NE(whole, old) << w.name;
  Kills out;
  for (int i = 0; i < count && !testing::Test::HasFailure(); ++i) {
    put_old(lab, w);
    RunningTool tool(w.command, lab.folder());
    const auto started = Clock::now();
    std::this_thread::sleep_for(
        std::chrono::duration<double>(std::uniform_real_distribution<double>(0, 1.05 * run_s)(random)));
    const auto sent = Clock::now();
    tool.kill(signal);
    const ToolRun run = tool.wait();
    if (run.status == 0) {
      ++out.finished;
      run_s = std::min(run_s, seconds_since(started));  // the first run was slower than most
    } else {
      EXPECT_EQ(run.status, -signal) << w.name << ": " << run.err;
      out.slowest_end_s = std::max(out.slowest_end_s, seconds_since(sent));
      ++out.killed;
    }
    const Content now = content(lab, w);
    EXPECT_TRUE(now == old || now == whole) << w.name << ": " << now.size() << " files";
    EXPECT_TRUE(run.status != 0 || now == whole) << w.name << " reported success";
    ++(now == old ? out.old : out.whole);
    if (signal != SIGKILL) {
      EXPECT_EQ(leftovers(lab), std::vector<std::string>{}) << w.name;
    }
    const ToolRun next =
        run_tool({"angles", "instrument.toml", "--stage-deg", "20", "--arm-deg", "40", "-o", "next.fits", "--force"},
                 lab.folder());
    EXPECT_EQ(next.status, 0) << next.err;
    for (const std::string& left : leftovers(lab)) {
      EXPECT_TRUE(left.find("/tmp/.scatmap-tmp-") != std::string::npos) << w.name << " left " << left;
    }
  }
  // What gnuplot's folders left in TMPDIR goes with the next picture.
  const ToolRun last =
      run_tool({"compare", "maps/measured.fits", "maps/modelled.fits", "-o", "last", "--force"}, lab.folder());
  EXPECT_EQ(last.status, 0) << last.err;
  EXPECT_EQ(leftovers(lab), std::vector<std::string>{}) << w.name;
  std::printf(
      "%-9s %d killed, %d finished first; old output %d times, new one whole %d times; run %.3f s, slowest end %.3f "
      "s\n",
      w.name.c_str(), out.killed, out.finished, out.old, out.whole, run_s, out.slowest_end_s);
  return out;
}

}  // namespace scatmap::test
