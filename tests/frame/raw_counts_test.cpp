// Counts kept in 16 bits read as the floats they stand for, in every way they are read, and become floats when they are
// written to. Does not prove that readers choose the right kind (fits_image_test).
#include "scatmap/frame/raw_counts.h"

#include <gtest/gtest.h>

#include <vector>

namespace scatmap {
namespace {

constexpr int kRows = 5, kColumns = 77;

std::uint16_t value_at(int row, int column) {
  return static_cast<std::uint16_t>((row * 40503u + static_cast<unsigned>(column) * 2654435761u) >> 7u);
}

RawCounts narrow() {
  Grid<std::uint16_t> g(kRows, kColumns);
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) g(r, c) = value_at(r, c);
  }
  g(0, 0) = 0;
  g(4, 76) = 65535;
  return g;
}

float expected(int row, int column) {
  if (row == 0 && column == 0) return 0;
  return row == 4 && column == 76 ? 65535.0f : static_cast<float>(value_at(row, column));
}

void expect_all(const RawCounts& counts) {
  ASSERT_EQ(counts.rows(), kRows);
  ASSERT_EQ(counts.columns(), kColumns);
  ASSERT_EQ(counts.size(), static_cast<std::size_t>(kRows * kColumns));
  auto at = counts.begin();
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c, ++at) {
      EXPECT_EQ(counts(r, c), expected(r, c));
      EXPECT_EQ(counts[static_cast<std::size_t>(r * kColumns + c)], expected(r, c));
      EXPECT_EQ(*at, expected(r, c));
    }
  }
  EXPECT_TRUE(at == counts.end());
  for (const int first : {0, 1, 13, 76}) {
    std::vector<float> buffer(kColumns);
    for (int r = 0; r < kRows; ++r) {
      const float* part = counts.part(r, first, kColumns - first, buffer.data());
      for (int i = 0; i < kColumns - first; ++i) EXPECT_EQ(part[i], expected(r, first + i));
    }
  }
}

TEST(RawCounts, SixteenBitsReadAsFloats) {
  expect_all(narrow());
  EXPECT_FALSE(narrow().empty());
  EXPECT_TRUE(RawCounts().empty());
  EXPECT_TRUE(narrow().same_shape(Grid<double>(kRows, kColumns)));
  EXPECT_FALSE(narrow().same_shape(Grid<double>(kColumns, kRows)));
}

TEST(RawCounts, WrittenToTheyAreFloats) {
  RawCounts counts = narrow();
  counts(2, 3) = 0.5f;
  EXPECT_EQ(std::as_const(counts)(2, 3), 0.5f);
  counts(2, 3) = expected(2, 3);
  expect_all(counts);
  for (float& v : counts.floats()) v += 0.25f;
  EXPECT_EQ(std::as_const(counts)[7], expected(0, 7) + 0.25f);
}

TEST(RawCounts, FloatsStayWhereTheyAre) {
  Grid<float> g(1, 4, -1.5f);
  const float* const at = g.data();
  const RawCounts counts(std::move(g));
  EXPECT_EQ(counts.part(0, 1, 3, nullptr), at + 1);
}

}  // namespace
}  // namespace scatmap
