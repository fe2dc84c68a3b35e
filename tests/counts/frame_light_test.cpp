// Sum, largest value and how often it stands, against loops written here.
#include "scatmap/counts/frame_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace scatmap {
namespace {

TEST(FrameLight, AsCountedOneByOne) {
  std::mt19937_64 rng(5);
  for (const int columns : {1, 7, 31, 32, 33, 64, 200}) {
    Grid<float> dn(9, columns);
    double sum = 0;
    float largest = -1;
    for (float& v : dn) {
      v = static_cast<float>(rng() % 50);
      if (rng() % 10 == 0) v = std::nanf("");
      if (std::isnan(v)) continue;
      sum += v;
      largest = std::max(largest, v);
    }
    std::size_t count = 0;
    for (const float v : dn) count += v == largest;
    const FrameLight light = frame_light(dn);
    EXPECT_EQ(light.sum_dn, sum) << columns;  // whole numbers: exact in any order
    if (count == 0) continue;
    EXPECT_EQ(light.largest_dn, largest) << columns;
    EXPECT_EQ(light.at_largest, count) << columns;
  }
}

TEST(FrameLight, OfNothing) {
  const FrameLight light = frame_light(Grid<float>(3, 40, std::nanf("")));
  EXPECT_EQ(light.sum_dn, 0);
  EXPECT_EQ(light.at_largest, 0u);
}

}  // namespace
}  // namespace scatmap
