// The same as frames_to_brdf_test.cpp with 40 seeds, so that the claim is measured and not its sampling error. By hand:
//   ctest --preset release -L slow        (the preset excludes slow tests by default; see docs/accuracy.md)
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/flow/frames_to_brdf.h"

namespace scatmap {
namespace {

class FramesToBrdfSlow : public testing::TestWithParam<const char*> {};

TEST_P(FramesToBrdfSlow, RmsWithinThreePerCentAndTheBiasBelowItsBound) {
  std::vector<unsigned> seeds;
  for (unsigned s = 1000; s < 1040; ++s) seeds.push_back(s);
  for (const test::Bin& b : test::frames_to_brdf(GetParam(), seeds)) {
    if (b.pixels < 2000) continue;
    const double rms = std::sqrt(b.square / b.pixels);
    std::printf("%s %10.4g e  %9.0f px  rms %.4f  mean error/standard error %+.2f  relative %+.2e\n", GetParam(),
                b.low_e, b.pixels, rms, b.error / std::sqrt(b.variance), b.error / b.truth);
    EXPECT_LE(std::abs(rms - 1), 0.03) << b.low_e;
    EXPECT_LE(std::abs(b.error), 3 * std::sqrt(b.variance) + (b.u_signature / std::sqrt(40.0) * 3 + 5e-4) * b.truth)
        << b.low_e;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, FramesToBrdfSlow,
                         testing::Values("small-20-0", "small-60-0", "small-40-45", "small-40-90", "small-20-45",
                                         "small-60-45", "hdr-20-0", "hdr-bloom", "dark", "every-parameter"));

}  // namespace
}  // namespace scatmap
