// Copies past the caches are copies, whatever the place and length, and touch nothing beside. Does not prove that they
// are faster: the charts show that.
#include "scatmap/base/stream_copy.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace scatmap {
namespace {

template <class T>
void expect_copies() {
  constexpr std::size_t kRoom = 400;
  std::vector<T> from(kRoom);
  std::iota(from.begin(), from.end(), T(1));
  for (std::size_t offset = 0; offset < 70; ++offset) {
    for (std::size_t count : {0, 1, 3, 31, 32, 33, 63, 64, 65, 127, 128, 200, 259}) {
      std::vector<T> to(kRoom, T(0)), expected(kRoom, T(0));
      stream_copy(from.data() + offset % 7, count, to.data() + offset);
      finish_streams();
      for (std::size_t i = 0; i < count; ++i) expected[offset + i] = from[offset % 7 + i];
      EXPECT_EQ(to, expected) << offset << " " << count;
    }
  }
}

TEST(StreamCopy, CopiesAnyLengthToAnyPlace) {
  expect_copies<double>();
  expect_copies<float>();
  expect_copies<std::uint16_t>();
}

}  // namespace
}  // namespace scatmap
