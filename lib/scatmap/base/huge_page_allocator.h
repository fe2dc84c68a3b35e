#pragma once
#include <cstddef>
#include <new>
#include <utility>

namespace scatmap {

/// @return `bytes` of uninitialised memory, 64-byte-aligned; 2 MiB-aligned and advised to use huge pages when it is
/// large: the first touch of 4 KiB pages costs 4 to 11 ns per pixel, more than the arithmetic of a map. Large blocks
/// that were freed are kept, and their pages serve those to come, of whatever size; in use and kept together never
/// exceed the most that was in use at once. Any thread. @throws std::bad_alloc
void* allocate_pages(std::size_t bytes);
/// @param bytes  as allocated
void free_pages(void* memory, std::size_t bytes) noexcept;

/// Standard allocator over `allocate_pages` that leaves trivially constructible values uninitialised unless a value
/// is given, so that the kernel that fills a plane is the first to touch it.
template <class T>
struct HugePageAllocator {
  using value_type = T;
  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(allocate_pages(n * sizeof(T))); }
  void deallocate(T* p, std::size_t n) noexcept { free_pages(p, n * sizeof(T)); }
  template <class U>
  void construct(U* p) {
    ::new (static_cast<void*>(p)) U;
  }
  template <class U, class... Args>
  void construct(U* p, Args&&... args) {
    ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
  }
  friend bool operator==(const HugePageAllocator&, const HugePageAllocator&) { return true; }
};

}  // namespace scatmap
