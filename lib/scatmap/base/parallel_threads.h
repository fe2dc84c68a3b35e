#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <functional>
#include <thread>

namespace scatmap {

/// for_ranges() of parallel.h where ThreadSanitizer watches: it does not see how oneTBB, whose library is not
/// instrumented, orders a loop and its tasks, so a few plain threads do the work. Ranges are drawn from a relaxed
/// counter, which orders nothing: a race between two ranges is seen whichever threads ran them.
template <class Index, class Work>
void for_ranges_on_threads(Index count, Index grain, const Work& work) {
  constexpr std::size_t kThreads = 3;
  std::atomic<Index> next{0};
  std::array<std::exception_ptr, kThreads> failures;
  const auto draw = [&](std::exception_ptr& failure) {
    try {
      for (;;) {
        const Index first = next.fetch_add(grain, std::memory_order_relaxed);
        if (first >= count) return;
        work(first, std::min<Index>(count, first + grain));
      }
    } catch (...) {
      failure = std::current_exception();
    }
  };
  {
    std::array<std::jthread, kThreads> threads;
    for (std::size_t i = 0; i < kThreads; ++i) threads[i] = std::jthread(draw, std::ref(failures[i]));
  }
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

}  // namespace scatmap
