// The numbers the paper prints for its own model (Sec. 4.4.2, Fig. 8), with its parameters (4.4.1).
// Not proven: agreement with its measurements; 1 % is the accuracy of three printed digits on a pixel grid.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "model/scene.h"
#include "scatmap/model/model.h"

namespace scatmap {
namespace {

using test::kDistance_m;
using test::kHalfHeight_m;
using test::sensor_direction;
using test::source_deg;

constexpr std::size_t kOffset = 1, kStripes = 2;

TEST(PaperModel, CentrePeaks) {
  for (const auto& [theta_i_deg, printed] : {std::pair{20.0, 1.11e4}, std::pair{60.0, 3.91e4}}) {
    const PreparedModel model(test::paper_model(), source_deg(theta_i_deg), kDistance_m);
    EXPECT_NEAR(model(sensor_direction(theta_i_deg, 0, 0)), printed, 0.01 * printed);
  }
}

struct Peak {
  double value = 0, right_m = 0, down_m = 0;
};

// The largest value on ever finer grids over the sensor.
Peak offset_peak(double theta_i_deg) {
  const PreparedModel model(test::paper_model(), source_deg(theta_i_deg), kDistance_m);
  Peak best;
  double half_m = 6e-3;
  constexpr int kSteps = 200;
  for (int level = 0; level < 6; ++level, half_m /= 20) {
    const Peak middle = best;
    for (int i = -kSteps; i <= kSteps; ++i) {
      for (int j = -kSteps; j <= kSteps; ++j) {
        const double right = middle.right_m + half_m * i / kSteps, down = middle.down_m + half_m * j / kSteps;
        const double value = model.term(kOffset, sensor_direction(theta_i_deg, right, down));
        if (value > best.value) best = {value, right, down};
      }
    }
  }
  best.value = model(sensor_direction(theta_i_deg, best.right_m, best.down_m));
  return best;
}

TEST(PaperModel, OffsetPeaks) {
  const Peak at_20 = offset_peak(20), at_60 = offset_peak(60);
  EXPECT_NEAR(at_20.value, 4.44e4, 0.01 * 4.44e4);
  EXPECT_NEAR(at_60.value, 4.19e5, 0.01 * 4.19e5);
  // To the right and down, and the way down compressed at the higher angle; millimetres.
  EXPECT_NEAR(at_20.right_m * 1e3, 4.02, 0.006);
  EXPECT_NEAR(at_20.down_m * 1e3, 3.76, 0.006);
  EXPECT_NEAR(at_60.right_m * 1e3, 4.02, 0.006);
  EXPECT_NEAR(at_60.down_m * 1e3, 1.98, 0.006);
}

// Values at the maxima along the crest of the diffraction pattern, from next to the centre down to the edge of a sensor
// of the given half height. The crest is where the half vector has no x component: wsx = sin(theta_i).
std::vector<double> crest_maxima(const Model& model, double theta_i_deg, double half_height_m) {
  const PreparedModel prepared(model, source_deg(theta_i_deg), kDistance_m);
  const double x = std::sin(theta_i_deg * kRadPerDeg), c = std::cos(theta_i_deg * kRadPerDeg);
  std::vector<double> values, found;
  for (double y = 0;; y += 1e-6) {
    const double z = std::sqrt(1 - x * x - y * y);
    if (kDistance_m * y / (x * x + c * z) > half_height_m) break;
    values.push_back(prepared.term(kStripes, {x, y, z}));
  }
  for (std::size_t i = 1; i + 1 < values.size(); ++i) {
    if (values[i] > values[i - 1] && values[i] >= values[i + 1]) found.push_back(values[i]);
  }
  return found;
}

TEST(PaperModel, TwentySixMaximaFallingFrom300To209) {
  for (const double theta_i_deg : {20.0, 60.0}) {
    const auto found = crest_maxima(test::paper_model(), theta_i_deg, kHalfHeight_m);
    ASSERT_EQ(found.size(), 26U) << theta_i_deg;
    EXPECT_NEAR(found.front(), 300, 3);
    EXPECT_NEAR(found.back(), 209, 2.09);
    const PreparedModel model(test::paper_model(), source_deg(theta_i_deg), kDistance_m);
    EXPECT_NEAR(model.term(kStripes, sensor_direction(theta_i_deg, 0, 0)), 300, 1e-9);
  }
}

// Without the factor 2 cos(theta_i) of Eq. 9 the paper counts 14 maxima at 20 deg and 26 at 60. The 14th lies 6.77 mm
// from the centre: it needs a sensor of 13.53 mm or more, within what is known of its height (13.5 +- 0.15 mm).
TEST(PaperModel, MaximaWithoutTheFactorTwoCosine) {
  constexpr double kHalf_m = 6.8e-3;
  for (const auto& [theta_i_deg, printed] : {std::pair{20.0, 14U}, std::pair{60.0, 26U}}) {
    Model bare = test::paper_model();
    auto& stripes = std::get<StripesTerm>(bare.terms[kStripes]);
    const double factor = 2 * std::cos(theta_i_deg * kRadPerDeg);
    stripes.a_m /= factor;
    stripes.b_m /= factor;
    EXPECT_EQ(crest_maxima(bare, theta_i_deg, kHalf_m).size(), printed);
    EXPECT_EQ(crest_maxima(test::paper_model(), theta_i_deg, kHalf_m).size(), 26U);
  }
}

// Figs. 9 and 10: phi_ref turns stripes and offset peak together about the centre.
TEST(PaperModel, PhiRefTurnsThePattern) {
  const PreparedModel turned(test::paper_model(90), source_deg(40), kDistance_m);
  const double along_x = turned.term(kStripes, sensor_direction(40, 2e-3, 0));
  const double along_y = turned.term(kStripes, sensor_direction(40, 0, 2e-3));
  EXPECT_GT(along_x, 1e-3);
  EXPECT_LT(along_y, 1e-6);
  // An azimuth of 45 + 90 deg points back and down: the offset peak lies to the left and below.
  double left = 0, right = 0;
  for (int i = 0; i <= 300; ++i) {
    for (int j = 0; j <= 300; ++j) {
      left = std::max(left, turned.term(kOffset, sensor_direction(40, -2e-5 * i, 2e-5 * j)));
      right = std::max(right, turned.term(kOffset, sensor_direction(40, 2e-5 * i, 2e-5 * j)));
    }
  }
  EXPECT_GT(left, 1e4);
  EXPECT_LT(right, 1);
}

}  // namespace
}  // namespace scatmap
