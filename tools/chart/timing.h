#pragma once
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>
#include <vector>

#include "tools/chart/chart.h"

namespace scatmap::tools {

/// Runs `work` again and again for about `seconds`, five times at least, after a first run that stands apart.
template <class Work>
Timing time_per_item(std::size_t items, double seconds, Work&& work) {
  using Clock = std::chrono::steady_clock;
  const auto once = [&] {
    const Clock::time_point start = Clock::now();
    work();
    return std::chrono::duration<double, std::nano>(Clock::now() - start).count() / static_cast<double>(items);
  };
  const double first = once();
  std::vector<double> ns;
  const Clock::time_point begin = Clock::now();
  while (ns.size() < 5 || Clock::now() - begin < std::chrono::duration<double>(seconds)) ns.push_back(once());
  std::sort(ns.begin(), ns.end());
  return {ns.front(), ns[ns.size() * 9 / 10] - ns.front(), first};
}

/// The result of `work` with at most `threads` of oneTBB's threads.
template <class Work>
auto with_threads(int threads, Work&& work) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  return std::forward<Work>(work)();
}

/// Keeps the compiler from dropping work whose result nobody reads.
inline void keep(const void* result) { asm volatile("" : : "g"(result) : "memory"); }

}  // namespace scatmap::tools
