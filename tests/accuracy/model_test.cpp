// The methods of the model against the simulator's long double (its own text: complex factors one by one, trigonometric
// turns) in twelve regimes, and `culled` against `vector` on frames made to break its bounds. The same with more
// samples: model_slow_test.cpp. Not proven: anything outside the regimes' ranges (model_regimes.cpp states them), or
// about the equations themselves.
#include <gtest/gtest.h>

#include <cstdio>

#include "accuracy/model_methods.h"

namespace scatmap::accuracy {
namespace {

class ModelMethods : public testing::TestWithParam<int> {};

TEST_P(ModelMethods, KeepTheirBounds) {
  const auto regime = static_cast<Regime>(GetParam());
  const RegimeErrors e = measure_regime(regime, 60, 256, 20260801);
  for (const auto& [name, errors] : {std::pair{"exact", e.exact}, {"vector", e.vector}, {"single", e.single}}) {
    EXPECT_LE(errors.largest_of_allowed, 1) << name << " " << errors.largest << " at " << errors.where;
    EXPECT_GT(errors.samples, 60 * 256 / 4) << name;
    std::printf("%-10s %-7s largest %.2e, %.3f of what is allowed\n", regime_name(regime), name, errors.largest,
                errors.largest_of_allowed);
  }
}

INSTANTIATE_TEST_SUITE_P(Regimes, ModelMethods, testing::Range(0, kRegimeCount),
                         [](const auto& i) { return std::string(regime_name(static_cast<Regime>(i.param))); });

TEST(CulledModel, KeepsItsToleranceOnAdversarialFrames) {
  const CullingErrors e = measure_culling(150, 20260802);
  EXPECT_LE(e.largest_of_allowed, 1) << e.where;
  EXPECT_LE(e.largest_of_allowed_truth, 1) << e.where_truth;
  EXPECT_GT(e.truths, 750);
  EXPECT_GT(e.pixels, 1000000);
  std::printf("%ld pixels, largest %.3f of what is allowed: %s\n", e.pixels, e.largest_of_allowed, e.where.c_str());
  std::printf("%ld truths, largest %.3f of what is allowed: %s\n", e.truths, e.largest_of_allowed_truth,
              e.where_truth.c_str());
}

TEST(PixelAverages, KeepTheirToleranceOnAdversarialFrames) {
  const MethodErrors e = measure_averages(20, 20260805);
  EXPECT_LE(e.largest_of_allowed, 1) << e.where;
  EXPECT_GT(e.samples, 40);
  std::printf("%ld means, largest %.3f of what is allowed: %s\n", e.samples, e.largest_of_allowed, e.where.c_str());
}

}  // namespace
}  // namespace scatmap::accuracy
