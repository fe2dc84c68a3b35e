// Freed planes serve the next of their size, and never make a program hold more than the most it had in use. Does not
// prove what the kernel does with the advice on page size. AddressSanitizer's builds keep nothing: there only the first
// test says something.
#include "scatmap/base/huge_page_allocator.h"

#include <gtest/gtest.h>
#include <unistd.h>

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
        auto* p = static_cast<std::size_t*>(allocate_pages(8 * kMiB));
        *p = t;
        std::this_thread::yield();
        wrong[t] += *p != t;
        free_pages(p, 8 * kMiB);
      }
    });
  }
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, std::vector<int>(4));
}

#endif

}  // namespace
}  // namespace scatmap
