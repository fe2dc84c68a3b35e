#pragma once
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace scatmap {

/// Calls work(first_row, last_row) for disjoint ranges that cover [0, rows), on oneTBB's threads. Work that depends on
/// its rows alone gives the same bytes at any thread count.
template <class Work>
void for_row_ranges(int rows, Work&& work) {
  tbb::parallel_for(tbb::blocked_range<int>(0, rows, 8),
                    [&](const tbb::blocked_range<int>& range) { work(range.begin(), range.end()); });
}

/// Calls work(row) for every row.
template <class Work>
void for_each_row(int rows, Work&& work) {
  for_row_ranges(rows, [&](int first, int last) {
    for (int row = first; row < last; ++row) work(row);
  });
}

}  // namespace scatmap
