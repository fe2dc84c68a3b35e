// monte_carlo_test with 2000 trials.
#include "monte_carlo.h"

namespace scatmap::calib::test {
namespace {

constexpr int kTrials = 2000;

void expect_honest_at(const Noise& noise, std::size_t targets, std::uint64_t seed, bool select = true) {
  CalibrateOptions options;
  options.select = select;
  const Statistics s = run_trials(noise, targets, kTrials, seed, options);
  print(s, std::string(select ? "default, " : "all, ") + std::to_string(targets) + " targets, " +
               std::to_string(noise.sigma_px) + " px");
  expect_honest(s);
}

TEST(MonteCarloSlow, FineEncoders25) { expect_honest_at({0.05, 0.0005}, 25, 501); }
TEST(MonteCarloSlow, FineEncoders80) { expect_honest_at({0.05, 0.0005}, 80, 502); }
TEST(MonteCarloSlow, FineEncoders200) { expect_honest_at({0.05, 0.0005}, 200, 503); }
TEST(MonteCarloSlow, CoarseEncoders25) { expect_honest_at({0.1, 0.005}, 25, 504); }
TEST(MonteCarloSlow, CoarseEncoders80) { expect_honest_at({0.1, 0.005}, 80, 505); }
TEST(MonteCarloSlow, CoarseEncoders200) { expect_honest_at({0.1, 0.005}, 200, 506); }
TEST(MonteCarloSlow, EveryParameterFine) { expect_honest_at({0.05, 0.0005}, 80, 507, false); }
TEST(MonteCarloSlow, EveryParameterCoarse) { expect_honest_at({0.1, 0.005}, 80, 508, false); }

}  // namespace
}  // namespace scatmap::calib::test
