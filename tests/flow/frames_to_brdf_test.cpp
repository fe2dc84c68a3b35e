// Raw frames → BRDF against the simulator's truth, at every signal level including the floor: u_random is the spread,
// and the mean is the truth. Two seeds per scene here; tests/flow/frames_to_brdf_slow_test.cpp runs many. Does not
// prove that a real sensor's noise is Poisson and Gaussian, nor anything about scale or pose errors.
#include "tests/flow/frames_to_brdf.h"

#include <gtest/gtest.h>

#include <cmath>

namespace scatmap {
namespace {

constexpr double kRmsClaim = 0.03;  // (measured − truth)/u_random has rms 1 within this, beside the sample's own error
constexpr double kBiasBound = 1e-3;  // of the truth, beside the mean's own standard error

class FramesToBrdf : public testing::TestWithParam<const char*> {};

TEST_P(FramesToBrdf, UncertaintyHoldsAndTheMeanIsTheTruthAtEveryLevel) {
  const std::vector<unsigned> seeds{101, 102};
  double pixels = 0;
  for (const test::Bin& b : test::frames_to_brdf(GetParam(), seeds)) {
    pixels += b.pixels;
    if (b.pixels < 100) continue;
    const double rms = std::sqrt(b.square / b.pixels);
    EXPECT_LE(std::abs(rms - 1), kRmsClaim + 3 / std::sqrt(2 * b.pixels))
        << b.low_e << " e: rms " << rms << " of " << b.pixels << " pixels";
    EXPECT_LE(std::abs(b.error), 3 * std::sqrt(b.variance) + (3 * b.u_signature + kBiasBound) * b.truth)
        << b.low_e << " e";
  }
  EXPECT_GE(pixels, 500000);
}

INSTANTIATE_TEST_SUITE_P(Scenes, FramesToBrdf,
                         testing::Values("small-20-0", "small-60-0", "small-40-45", "small-40-90", "small-20-45",
                                         "small-60-45", "hdr-20-0", "hdr-bloom", "dark", "every-parameter"));

}  // namespace
}  // namespace scatmap
