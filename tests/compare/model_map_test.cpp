// A modelled map: its mask and NaN, its methods against `exact` on an instrument's pixels, and what it says about them.
// Not proven: the methods' own bounds (accuracy/model_test.cpp).
#include "scatmap/compare/model_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scatmap/base/units.h"

namespace scatmap {
namespace {

Instrument instrument() {
  Instrument in;
  in.columns = 330;
  in.rows = 247;
  in.geometry.distance = 0.325;
  in.geometry.pixel_column = in.geometry.pixel_row = 5.5e-5;
  return in;
}

Model model() {
  return {632.8e-9,
          Polarization::kP,
          0.3,
          {MicrofacetTerm{0.7, 2e-4, 1.4, 0.5 * kRadPerDeg, 45 * kRadPerDeg}, MicrofacetTerm{0.015, 2e-3, {3.6, 0.2}},
           StripesTerm{300, 8e-4, 1e-5, 4e-5, StripesForm::kGrating}, LambertianTerm{0.05}}};
}

const Pose kPose{20 * kRadPerDeg, 40 * kRadPerDeg};

TEST(ModelMap, MethodsKeepTheirBoundsOnAnInstrumentsPixels) {
  const BrdfMap exact = model_map(model(), instrument(), kPose);
  double peak = 0;
  for (const double v : exact.brdf_per_sr) peak = std::max(peak, v);
  EXPECT_GT(peak, 1000);
  const double rounding =
      2 * model_rounding_error(model(), sample_view(instrument(), kPose).to_source, instrument().geometry.distance);
  for (const FrameModelOptions& options : {FrameModelOptions{ModelMethod::kVector},
                                           {ModelMethod::kSingle},
                                           {ModelMethod::kCulled, 1e-3},
                                           {ModelMethod::kCulled, 1e-9}}) {
    const BrdfMap map = model_map(model(), instrument(), kPose, options);
    double largest = 0;
    for (std::size_t i = 0; i < map.brdf_per_sr.size(); ++i) {
      const double error = std::abs(map.brdf_per_sr[i] - exact.brdf_per_sr[i]);
      largest = std::max(largest, error / std::max(exact.brdf_per_sr[i], kPeakShare * peak));
    }
    EXPECT_LE(largest, model_error_bound(options) + rounding) << model_method_name(options.method);
    EXPECT_GT(largest, 0);  // or the method was not used
  }
}

TEST(ModelMap, SaysHowItWasMade) {
  const auto note = [](const FrameModelOptions& options) {
    return model_map(model(), instrument(), kPose, options).notes.at(0);
  };
  EXPECT_NE(note({}).find("method exact, error at most 1e-12"), std::string::npos) << note({});
  EXPECT_NE(note({ModelMethod::kCulled, 1e-4}).find("method culled, error at most 1e-04"), std::string::npos)
      << note({ModelMethod::kCulled, 1e-4});
  EXPECT_NE(note({ModelMethod::kCulled, 1e-4, true}).find("means over the pixels"), std::string::npos);
}

TEST(ModelMap, MasksWhatTheDetectorCannotSee) {
  Instrument wide = instrument();
  wide.geometry.pixel_column = 3e-3;  // 72 degrees to each side: columns reach below the horizon
  for (const ModelMethod method : {ModelMethod::kExact, ModelMethod::kVector, ModelMethod::kCulled}) {
    const BrdfMap map = model_map(model(), wide, {60 * kRadPerDeg, 120 * kRadPerDeg}, {method});
    int masked = 0;
    for (std::size_t i = 0; i < map.mask.size(); ++i) {
      EXPECT_EQ(std::isnan(map.brdf_per_sr[i]), map.mask[i] != 0) << i;
      masked += map.mask[i] != 0 ? 1 : 0;
    }
    EXPECT_GT(masked, 0);
    EXPECT_LT(masked, static_cast<int>(map.mask.size()));
  }
}

}  // namespace
}  // namespace scatmap
