#include "scatmap/base/huge_page_allocator.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <vector>

namespace scatmap {
namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kPage = 4096, kAlignment = 64;
// Blocks from here on are mapped on their own and kept: in malloc's heap, where blocks of other sizes come between,
// they would leave holes that grow.
constexpr std::size_t kMappedFrom = std::size_t{256} << 10;

// AddressSanitizer finds what is used after it was freed only in memory of its own.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool kMap = false;
#elif defined(__has_feature)
constexpr bool kMap = !__has_feature(address_sanitizer);
#else
constexpr bool kMap = true;
#endif

bool is_mapped(std::size_t size) { return kMap && size >= kMappedFrom; }

std::size_t rounded(std::size_t bytes) {
  const std::size_t unit = bytes >= kHugePage ? kHugePage : bytes >= kMappedFrom ? kPage : kAlignment;
  if (bytes > static_cast<std::size_t>(-1) - unit - kHugePage) throw std::bad_alloc();
  return std::max(unit, (bytes + unit - 1) / unit * unit);
}

// @return nullptr where there is none
void* map_pages(std::size_t size) {
  const std::size_t slack = size >= kHugePage ? kHugePage : 0;  // to begin at a huge page
  void* const mapped = mmap(nullptr, size + slack, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED) return nullptr;
  if (slack == 0) return mapped;
  auto* const begin = static_cast<std::byte*>(mapped);
  const std::size_t past = reinterpret_cast<std::uintptr_t>(mapped) % kHugePage,
                    head = past == 0 ? 0 : kHugePage - past;
  if (head > 0) munmap(begin, head);
  if (head < slack) munmap(begin + head + size, slack - head);
#ifdef MADV_HUGEPAGE
  madvise(begin + head, size, MADV_HUGEPAGE);  // advice: failure changes speed only
#endif
  return begin + head;
}

// Blocks that were freed, for those to come. The pages of large ones move from address to address as they are needed:
// to clear fresh ones costs more than a map's arithmetic. In use and kept together are never more than the most that
// was in use at once.
class KeptPages {
 public:
  KeptPages() { kept_.reserve(kMost); }

  void* take(std::size_t size) {
    const std::lock_guard lock(mutex_);
    void* memory = kept_of(size);
    if (memory == nullptr && size >= kHugePage) memory = gathered(size);
    drop_beyond(std::max(most_bytes_, used_bytes_ + size) - used_bytes_ - size);
    if (memory == nullptr) memory = map_pages(size);
    if (memory == nullptr) {
      drop_beyond(0);
      memory = map_pages(size);
    }
    if (memory == nullptr) return nullptr;
    used_bytes_ += size;
    most_bytes_ = std::max(most_bytes_, used_bytes_);
    return memory;
  }

  void give(void* memory, std::size_t size) noexcept {
    const std::lock_guard lock(mutex_);
    used_bytes_ -= size;
    if (kept_.size() == kept_.capacity()) {  // nothing is reserved on the way out
      munmap(memory, size);
      return;
    }
    kept_bytes_ += size;
    kept_.push_back({static_cast<std::byte*>(memory), size});
  }

 private:
  struct Block {
    std::byte* memory;
    std::size_t size;
  };

  static constexpr std::size_t kMost = 256;  // blocks

  // @return nullptr: none is of that size
  void* kept_of(std::size_t size) {
    const auto at = std::find_if(kept_.rbegin(), kept_.rend(), [&](const Block& b) { return b.size == size; });
    if (at == kept_.rend()) return nullptr;
    void* const memory = at->memory;
    kept_bytes_ -= size;
    kept_.erase(std::next(at).base());
    return memory;
  }

  // A block made of the pages of others, the newest first, and of fresh ones where those do not suffice.
  // @return nullptr: there are none, or they cannot be moved
  void* gathered(std::size_t size) {
    auto* const memory = kept_bytes_ > 0 ? static_cast<std::byte*>(map_pages(size)) : nullptr;
    if (memory == nullptr) return nullptr;
    std::size_t done = 0;
    bool moved = true;
    for (auto at = kept_.end(); moved && done < size && at != kept_.begin();) {
      Block& block = *--at;
      for (; moved && done < size && block.size >= kHugePage; done += kHugePage) {
        block.size -= kHugePage;
        kept_bytes_ -= kHugePage;
        moved = move_page(block.memory + block.size, memory + done);
        if (!moved) munmap(block.memory + block.size, kHugePage);
      }
    }
    std::erase_if(kept_, [](const Block& b) { return b.size == 0; });
    if (moved) return memory;
    munmap(memory, size);
    return nullptr;
  }

  // One by one, as the pages of a block may come from several mappings.
  static bool move_page(void* from, void* to) {
    return mremap(from, kHugePage, kHugePage, MREMAP_MAYMOVE | MREMAP_FIXED, to) == to;
  }

  // The oldest go first.
  void drop_beyond(std::size_t bytes) {
    auto last = kept_.begin();
    for (; last != kept_.end() && kept_bytes_ > bytes; ++last) {
      munmap(last->memory, last->size);
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

}  // namespace

void* allocate_pages(std::size_t bytes) {
  const std::size_t size = rounded(bytes);
  const std::size_t alignment = size >= kHugePage ? kHugePage : kAlignment;
  void* memory = is_mapped(size) ? kept_pages().take(size) : std::aligned_alloc(alignment, size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void free_pages(void* memory, std::size_t bytes) noexcept {
  const std::size_t size = rounded(bytes);
  if (is_mapped(size)) return kept_pages().give(memory, size);
  std::free(memory);
}

}  // namespace scatmap
