#pragma once
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/accuracy/angle_errors.h"
#include "tests/accuracy/regimes.h"

namespace scatmap::test {

/// Every method within its bound; prints the worst shares. @return samples of the least sampled method but `linear`
inline long long expect_within_bounds(std::size_t regime, const AngleErrors& errors) {
  long long fewest = -1;
  for (const auto& [name, worst] : errors.methods) {
    SCOPED_TRACE(name + ", " + kRegimes[regime]);
    std::printf("%-22s %-7s %9lld samples, worst %.2Le rad, %.3Lf of the bound in rad, %.3Lf in px\n", kRegimes[regime],
                name.c_str(), worst.samples, worst.error_rad, worst.share_rad, worst.share_px);
    EXPECT_LE(worst.share_rad, 1);
    EXPECT_LE(worst.share_px, 1);
    EXPECT_EQ(worst.wrong_pixels, 0);
    if (name != "linear" && (fewest < 0 || worst.samples < fewest)) fewest = worst.samples;
  }
  std::printf("%-22s solid angle %.3Lf, cosine %.3Lf, single %.3Lf %.3Lf, from the file's numbers %.3Lf\n",
              kRegimes[regime], errors.solid_angle_share, errors.cosine_share, errors.single_solid_angle_share,
              errors.single_cosine_share, errors.chain_share);
  EXPECT_LE(errors.solid_angle_share, 1);
  EXPECT_LE(errors.cosine_share, 1);
  EXPECT_LE(errors.single_solid_angle_share, 1);
  EXPECT_LE(errors.single_cosine_share, 1);
  EXPECT_LE(errors.chain_share, 1);
  return fewest;
}

}  // namespace scatmap::test
