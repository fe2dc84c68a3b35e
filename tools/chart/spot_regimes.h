#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "calib/spots.h"

namespace scatmap::tools {

/// Light of one spot before the pixels: an elliptical Gaussian, a disc with soft edges, or a ring.
struct SpotLight {
  enum class Shape { kGaussian, kFlatTop, kRing } shape = Shape::kGaussian;
  double column_px = 24.3, row_px = 23.6;
  double flux_e = 1e5;
  double major_px = 1.7, minor_px = 1.7;  ///< standard deviations; of a disc or ring: its radius, and the ring's width
  double angle_rad = 0;
};

/// One frame of a camera whose every number is known.
struct SpotScene {
  int columns = 48, rows = 48;
  std::vector<SpotLight> spots = std::vector<SpotLight>(1);
  double gain_e_per_dn = 1.5, read_noise_e = 8, bias_dn = 300, saturation_dn = 1e7;
  double background_e = 20;
  std::array<double, 2> slope_e_per_px{0, 0};  ///< of the background about the frame's middle, along columns and rows
  std::optional<double> dark_dn = 300;         ///< absent: no dark is given
  bool noise = true;
  struct Pixel {
    int column, row;
    double value_dn;  ///< may be NaN
  };
  std::vector<Pixel> replaced;          ///< after the exposure
  std::optional<double> every_dn = {};  ///< all pixels, instead of an exposure
};

enum class SpotExpectation {
  kFound,   ///< a spot must come of it
  kEither,  ///< too little light, or too little of it in the frame: a spot or a reason
  kNone,    ///< nothing can come of it
};

struct SpotRegime {
  const char* name;
  SpotScene scene;
  SpotExpectation expectation = SpotExpectation::kFound;
  /// Spots so close that their light is as good as one Gaussian's: its place is anywhere between the brightest one's
  /// centre and the centre of all the light.
  bool as_one = false;
};

std::vector<SpotRegime> spot_regimes();

/// Expected electrons of light, row after row; written apart from calib's pixel integrals.
Grid<double> expected_light_e(const SpotScene& scene);
/// Frame of that light: normal noise of the right variance (the same deviates for the same seed), clipped, not rounded.
Frame exposed(const SpotScene& scene, const Grid<double>& light_e, std::uint64_t seed);
/// As `scatmap spots` measures it. @throws Error
calib::SpotsInFrame measured(const SpotScene& scene, const Frame& frame, calib::SpotMethod method);

}  // namespace scatmap::tools
