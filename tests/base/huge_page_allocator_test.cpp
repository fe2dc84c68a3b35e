// Freed planes serve those to come, and never make a program hold more than the most it had in use. Does not
// prove what the kernel does with the advice on page size. AddressSanitizer's builds keep nothing: there only the first
// test says something.
#include "scatmap/base/huge_page_allocator.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <thread>
#include <vector>

namespace scatmap {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

TEST(HugePageAllocator, BlocksAreAlignedWritableAndApart) {
  std::vector<std::pair<char*, std::size_t>> blocks;
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{1}, std::size_t{63}, kMiB, 2 * kMiB, 5 * kMiB + 1}) {
    for (int i = 0; i < 3; ++i) {
      char* p = static_cast<char*>(allocate_pages(bytes));
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(p) % (bytes >= 2 * kMiB ? 2 * kMiB : 64), 0u);
      std::memset(p, static_cast<int>(blocks.size()), bytes);
      blocks.emplace_back(p, bytes);
    }
  }
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    for (std::size_t k = 0; k < blocks[i].second; k += 511) EXPECT_EQ(blocks[i].first[k], static_cast<char>(i));
    free_pages(blocks[i].first, blocks[i].second);
  }
  EXPECT_THROW(allocate_pages(std::numeric_limits<std::size_t>::max()), std::bad_alloc);
}

#if !defined(__SANITIZE_ADDRESS__)

// All addresses of the process: mapped blocks are no part of malloc's heap.
std::size_t held() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

// Pages that this process touched first, whatever their size.
long fresh_pages() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  return use.ru_minflt;
}

char* written_block(std::size_t bytes, char value) {
  auto* const memory = static_cast<char*>(allocate_pages(bytes));
  std::memset(memory, value, bytes);
  return memory;
}

bool holds(const char* memory, std::size_t bytes, char value) {
  return std::all_of(memory, memory + bytes, [&](char c) { return c == value; });
}

TEST(HugePageAllocator, WhatNobodyHasIsRefused) {  // AddressSanitizer ends the program instead
  EXPECT_THROW(allocate_pages(std::numeric_limits<std::size_t>::max() / 2), std::bad_alloc);
}

TEST(HugePageAllocator, AFreedBlockServesTheNextOfItsSize) {
  void* const first = allocate_pages(40 * kMiB);
  void* const other = allocate_pages(6 * kMiB);
  free_pages(first, 40 * kMiB);
  void* const again = allocate_pages(40 * kMiB - 5);
  EXPECT_EQ(again, first);
  EXPECT_NE(other, first);
  free_pages(other, 6 * kMiB);
  free_pages(again, 40 * kMiB - 5);
}

// Planes of float become planes of double and the other way round.
TEST(HugePageAllocator, PagesOfFreedBlocksServeOthersOfAnySize) {
  constexpr long kFew = 4;
  char *first = written_block(34 * kMiB, 'a'), *second = written_block(34 * kMiB, 'b');
  char* const kept = written_block(10 * kMiB, 'k');
  ASSERT_GT(fresh_pages(), kFew);
  free_pages(first, 34 * kMiB);
  free_pages(second, 34 * kMiB);
  const long before = fresh_pages();
  char* const wide = written_block(66 * kMiB, 'w');
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(wide) % (2 * kMiB), 0u);
  char* const narrow = written_block(2 * kMiB, 'n');  // what is left of the two
  EXPECT_LE(fresh_pages(), before + kFew);
  EXPECT_TRUE(holds(wide, 66 * kMiB, 'w') && holds(narrow, 2 * kMiB, 'n') && holds(kept, 10 * kMiB, 'k'));
  free_pages(wide, 66 * kMiB);
  char* parts[4];
  for (char*& part : parts) part = written_block(16 * kMiB, static_cast<char>('0' + (&part - parts)));
  EXPECT_LE(fresh_pages(), before + kFew);
  for (char*& part : parts) {
    EXPECT_TRUE(holds(part, 16 * kMiB, static_cast<char>('0' + (&part - parts))));
    free_pages(part, 16 * kMiB);
  }
  free_pages(narrow, 2 * kMiB);
  free_pages(kept, 10 * kMiB);
}

TEST(HugePageAllocator, HoldsNoMoreThanTheMostThatWasInUse) {
  const std::size_t before = held();
  ASSERT_GT(before, kMiB);
  std::size_t most = 0;
  for (std::size_t size = 4; size <= 256; size *= 2) {  // each step frees what no later one can use
    std::vector<void*> blocks;
    for (int i = 0; i < 4; ++i) blocks.push_back(allocate_pages(size * kMiB));
    most = 4 * size * kMiB;
    EXPECT_LE(held(), before + most + 64 * kMiB) << size;  // alignment: up to a huge page per block
    for (void* p : blocks) free_pages(p, size * kMiB);
    EXPECT_LE(held(), before + most + 64 * kMiB) << size;
  }
}

TEST(HugePageAllocator, ThreadsShareIt) {
  std::vector<std::thread> threads;
  std::vector<int> wrong(4);
  for (std::size_t t = 0; t < wrong.size(); ++t) {
    threads.emplace_back([&wrong, t] {
      for (int i = 0; i < 300; ++i) {
        const std::size_t size = (i % 3 == 0 ? 16 : 6) * kMiB;  // moved pages too
        auto* p = static_cast<std::size_t*>(allocate_pages(size));
        auto* const last = p + size / sizeof *p - 1;
        *p = *last = t;
        std::this_thread::yield();
        wrong[t] += *p != t || *last != t;
        free_pages(p, size);
      }
    });
  }
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, std::vector<int>(4));
}

#endif

}  // namespace
}  // namespace scatmap
