#include "scatmap/frame/raw_counts.h"

#include "scatmap/base/simd.h"

namespace scatmap {
namespace {

SCATMAP_CLONES void widen(const std::uint16_t* __restrict from, int pixels, float* __restrict to) {
  SCATMAP_INDEPENDENT
  for (int i = 0; i < pixels; ++i) to[i] = static_cast<float>(static_cast<std::int32_t>(from[i]));
}

template <class T>
void prefetch_row(const T* row, int first, int last) {
  constexpr int kLine = 64 / sizeof(T);
  for (int c = first; c < last; c += kLine) __builtin_prefetch(row + c, 0, 2);
}

}  // namespace

const float* RawCounts::part(int row, int first, int pixels, float* buffer) const {
  if (!is_narrow()) return &wide_(row, first);
  widen(&narrow_(row, first), pixels, buffer);
  return buffer;
}

Grid<float>& RawCounts::floats() {
  if (is_narrow()) {
    wide_ = Grid<float>(narrow_.rows(), narrow_.columns());
    for (int r = 0; r < narrow_.rows(); ++r) widen(narrow_.row(r).data(), narrow_.columns(), wide_.row(r).data());
    narrow_ = {};
  }
  return wide_;
}

// Past the row's end is harmless: that is the next row, or an address that is not asked for.
void RawCounts::prefetch(int row, int first, int last) const {
  is_narrow() ? prefetch_row(narrow_.row(row).data(), first, last) : prefetch_row(wide_.row(row).data(), first, last);
}

}  // namespace scatmap
