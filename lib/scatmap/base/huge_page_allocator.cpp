#include "scatmap/base/huge_page_allocator.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <vector>

namespace scatmap {
namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kKeptFrom = std::size_t{8} << 20;  // smaller blocks, kept, would only scatter over malloc's heap

std::size_t rounded(std::size_t bytes) {
  constexpr std::size_t kCacheLine = 64;
  const std::size_t alignment = bytes >= kHugePage ? kHugePage : kCacheLine;
  if (bytes > static_cast<std::size_t>(-1) - alignment) throw std::bad_alloc();
  return std::max(alignment, (bytes + alignment - 1) / alignment * alignment);
}

void* fresh_pages(std::size_t size) {
  void* memory = std::aligned_alloc(size >= kHugePage ? kHugePage : 64, size);
#ifdef MADV_HUGEPAGE
  // Advice: failure changes speed only.
  if (memory != nullptr && size >= kHugePage) madvise(memory, size, MADV_HUGEPAGE);
#endif
  return memory;
}

// Blocks that were freed, for the next of their size: planes come in four sizes. In use and kept together are never
// more than the most that was in use at once.
class KeptPages {
 public:
  KeptPages() { kept_.reserve(kMost); }

  void* take(std::size_t size) {
    const std::lock_guard lock(mutex_);
    const auto at = std::find_if(kept_.rbegin(), kept_.rend(), [&](const Block& b) { return b.size == size; });
    void* memory = nullptr;
    if (at != kept_.rend()) {
      memory = at->memory;
      kept_bytes_ -= size;
      kept_.erase(std::next(at).base());
    } else {
      drop_beyond(std::max(most_bytes_, used_bytes_ + size) - used_bytes_ - size);
      memory = fresh_pages(size);
      if (memory == nullptr) {
        drop_beyond(0);
        memory = fresh_pages(size);
      }
      if (memory == nullptr) return nullptr;
    }
    used_bytes_ += size;
    most_bytes_ = std::max(most_bytes_, used_bytes_);
    return memory;
  }

  void give(void* memory, std::size_t size) noexcept {
    const std::lock_guard lock(mutex_);
    used_bytes_ -= size;
    if (kept_.size() == kept_.capacity()) return std::free(memory);  // nothing is reserved on the way out
    kept_bytes_ += size;
    kept_.push_back({memory, size});
  }

 private:
  struct Block {
    void* memory;
    std::size_t size;
  };

  static constexpr std::size_t kMost = 64;  // blocks

  // The oldest go first.
  void drop_beyond(std::size_t bytes) {
    auto last = kept_.begin();
    for (; last != kept_.end() && kept_bytes_ > bytes; ++last) {
      std::free(last->memory);
      kept_bytes_ -= last->size;
    }
    kept_.erase(kept_.begin(), last);
  }

  std::mutex mutex_;
  std::vector<Block> kept_;
  std::size_t used_bytes_ = 0, kept_bytes_ = 0, most_bytes_ = 0;
};

KeptPages& kept_pages() {
  static auto* const pages = new KeptPages;  // outlives every grid
  return *pages;
}

// AddressSanitizer finds what is used after it was freed only if it is freed.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool kKeep = false;
#elif defined(__has_feature)
constexpr bool kKeep = !__has_feature(address_sanitizer);
#else
constexpr bool kKeep = true;
#endif

bool is_kept(std::size_t size) { return kKeep && size >= kKeptFrom; }

}  // namespace

void* allocate_pages(std::size_t bytes) {
  const std::size_t size = rounded(bytes);
  void* memory = is_kept(size) ? kept_pages().take(size) : fresh_pages(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void free_pages(void* memory, std::size_t bytes) noexcept {
  const std::size_t size = rounded(bytes);
  if (is_kept(size)) return kept_pages().give(memory, size);
  std::free(memory);
}

}  // namespace scatmap
