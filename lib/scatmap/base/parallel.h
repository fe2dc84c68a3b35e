#pragma once
#include <cstddef>

#if defined(__SANITIZE_THREAD__)
#include "scatmap/base/parallel_threads.h"
#else
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#endif

namespace scatmap {

/// Calls work(first, last) for disjoint ranges that cover [0, count), on oneTBB's threads. Work that depends on its
/// indices alone gives the same bytes at any thread count.
/// @param grain  a range of at most this many indices is not divided further
/// @throws what work threw
template <class Index, class Work>
void for_ranges(Index count, Index grain, const Work& work) {
#if defined(__SANITIZE_THREAD__)
  for_ranges_on_threads(count, grain, work);
#else
  tbb::parallel_for(tbb::blocked_range<Index>(0, count, static_cast<std::size_t>(grain)),
                    [&](const tbb::blocked_range<Index>& range) { work(range.begin(), range.end()); });
#endif
}

/// As for_ranges, and calls work(index) for every index.
template <class Index, class Work>
void for_each_index(Index count, Index grain, const Work& work) {
  for_ranges(count, grain, [&](Index first, Index last) {
    for (Index i = first; i != last; ++i) work(i);
  });
}

/// Ranges of rows, of about eight or more.
template <class Work>
void for_row_ranges(int rows, const Work& work) {
  for_ranges(rows, 8, work);
}

/// Calls work(row) for every row.
template <class Work>
void for_each_row(int rows, const Work& work) {
  for_each_index(rows, 8, work);
}

}  // namespace scatmap
