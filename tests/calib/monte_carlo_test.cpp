// Honest uncertainties: standardised errors of every reported parameter and of directions at the centre and the
// corners, single and joint, over benches drawn from the mechanical tolerances, with noise in centroids and encoders.
// Defaults, and every parameter fitted. 300 trials each; 2000 in monte_carlo_slow_test. Does not prove the tolerances
// right.
#include "monte_carlo.h"

namespace scatmap::calib::test {
namespace {

constexpr int kTrials = 300;

void expect_honest_at(const Noise& noise, std::size_t targets, std::uint64_t seed, bool select = true) {
  CalibrateOptions options;
  options.select = select;
  const Statistics s = run_trials(noise, targets, kTrials, seed, options);
  print(s, std::string(select ? "default, " : "all, ") + std::to_string(targets) + " targets, " +
               std::to_string(noise.sigma_px) + " px");
  expect_honest(s);
}

TEST(MonteCarlo, FineEncoders25) { expect_honest_at({0.05, 0.0005}, 25, 401); }
TEST(MonteCarlo, FineEncoders80) { expect_honest_at({0.05, 0.0005}, 80, 402); }
TEST(MonteCarlo, FineEncoders200) { expect_honest_at({0.05, 0.0005}, 200, 403); }
TEST(MonteCarlo, CoarseEncoders25) { expect_honest_at({0.1, 0.005}, 25, 404); }
TEST(MonteCarlo, CoarseEncoders80) { expect_honest_at({0.1, 0.005}, 80, 405); }
TEST(MonteCarlo, CoarseEncoders200) { expect_honest_at({0.1, 0.005}, 200, 406); }
TEST(MonteCarlo, EveryParameterFine) { expect_honest_at({0.05, 0.0005}, 80, 407, false); }
TEST(MonteCarlo, EveryParameterCoarse) { expect_honest_at({0.1, 0.005}, 80, 408, false); }

// Why the covariance's ellipsoid is no joint region on a real bench: with tolerances and noise a tenth of the usual the
// model is straight enough within them, and then it is one.
TEST(MonteCarlo, EllipsoidIsAJointRegionOnceTheBenchIsLinear) {
  const Noise noise{0.005, 0.00005};
  CalibrateOptions options;
  options.select = false;
  const ParameterTable table(nominal_instrument(noise), {"", {""}, {}}, {});
  for (Eigen::Index i = 0; i < table.size(); ++i) {
    if (table[i].role != Role::kHeld)
      options.choices.prior_sigma[table[i].name] = 0.1 * table[i].prior_sigma / table[i].unit;
  }
  const Statistics s = run_trials(noise, 80, kTrials, 409, options);
  print(s, "a tenth of every tolerance and noise");
  const double n = kTrials, three_errors = 3 * std::sqrt(0.95 * 0.05 / n);
  EXPECT_NEAR(s.ellipsoid_inside / n, 0.95, three_errors);
  EXPECT_NEAR(s.joint_inside / n, 0.95, three_errors);
}

}  // namespace
}  // namespace scatmap::calib::test
