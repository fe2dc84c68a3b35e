#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace scatmap {

/// Planes of this size and more leave the caches before anybody reads them again. Written past the caches they cost
/// half the memory traffic: no line is fetched to be overwritten. Smaller ones are better written the usual way.
inline constexpr std::size_t kStreamedBytes = std::size_t{64} << 20;

/// As std::copy_n, past the caches where the processor can. Other threads see it after finish_streams().
/// @param to  aligned for T, overlaps nothing of `from`
template <class T>
void stream_copy(const T* from, std::size_t count, T* to) {
  static_assert(std::is_trivially_copyable_v<T>);
#if defined(__SSE2__)
  constexpr std::size_t kLine = 64, kPerLine = kLine / sizeof(T), kVector = sizeof(__m128i), kStores = kLine / kVector;
  const std::size_t past = reinterpret_cast<std::uintptr_t>(to) % kLine / sizeof(T);
  const std::size_t head = std::min(count, past == 0 ? 0 : kPerLine - past);
  std::copy_n(from, head, to);
  from += head;
  to += head;
  count -= head;
  for (; count >= kPerLine; count -= kPerLine, from += kPerLine, to += kPerLine) {
    const auto* in = reinterpret_cast<const __m128i*>(from);
    auto* out = reinterpret_cast<__m128i*>(to);
    for (std::size_t k = 0; k < kStores; ++k) _mm_stream_si128(out + k, _mm_loadu_si128(in + k));
  }
#endif
  std::copy_n(from, count, to);
}

/// Before other threads are told that what stream_copy() wrote is there.
inline void finish_streams() {
#if defined(__SSE2__)
  _mm_sfence();
#endif
}

}  // namespace scatmap
