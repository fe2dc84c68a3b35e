// model_test.cpp with at least 1e7 samples per method and 1e8 pixels of adversarial frames: some minutes.
#include <gtest/gtest.h>

#include <cstdio>

#include "accuracy/model_methods.h"

namespace scatmap::accuracy {
namespace {

TEST(ModelMethodsSlow, KeepTheirBounds) {
  long samples[3] = {};
  for (int i = 0; i < kRegimeCount; ++i) {
    const auto regime = static_cast<Regime>(i);
    const RegimeErrors e = measure_regime(regime, 4500, 256, 20260803);
    int method = 0;
    for (const auto& [name, errors] : {std::pair{"exact", e.exact}, {"vector", e.vector}, {"single", e.single}}) {
      EXPECT_LE(errors.largest_of_allowed, 1)
          << regime_name(regime) << " " << name << " " << errors.largest << " at " << errors.where;
      samples[method++] += errors.samples;
      std::printf("%-10s %-7s largest %.2e, %.3f of what is allowed\n", regime_name(regime), name, errors.largest,
                  errors.largest_of_allowed);
    }
  }
  for (const long n : samples) EXPECT_GE(n, 10000000);
}

TEST(CulledModelSlow, KeepsItsToleranceOnAdversarialFrames) {
  const CullingErrors e = measure_culling(4000, 20260804);
  EXPECT_LE(e.largest_of_allowed, 1) << e.where;
  EXPECT_LE(e.largest_of_allowed_truth, 1) << e.where_truth;
  EXPECT_GT(e.truths, 20000);
  EXPECT_GT(e.pixels, 100000000);
  std::printf("%ld pixels, largest %.3f of what is allowed: %s\n", e.pixels, e.largest_of_allowed, e.where.c_str());
  std::printf("%ld truths, largest %.3f of what is allowed: %s\n", e.truths, e.largest_of_allowed_truth,
              e.where_truth.c_str());
}

TEST(PixelAveragesSlow, KeepTheirToleranceOnAdversarialFrames) {
  const MethodErrors e = measure_averages(600, 20260806);
  EXPECT_LE(e.largest_of_allowed, 1) << e.where;
  EXPECT_GT(e.samples, 600);
  std::printf("%ld means, largest %.3f of what is allowed: %s\n", e.samples, e.largest_of_allowed, e.where.c_str());
}

}  // namespace
}  // namespace scatmap::accuracy
