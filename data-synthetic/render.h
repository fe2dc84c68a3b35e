#pragma once
#include <cstdint>
#include <vector>

#include "data-synthetic/truth_geometry.h"
#include "scatmap/base/grid.h"

namespace scatmap::synth {

/// The true sensor.
struct SensorTruth {
  double gain_e_per_dn = 1;
  double read_noise_e = 0;
  double bias_dn = 0;
  double saturation_dn = 65535;  ///< counts are cut at the smaller of this and adc_max_dn
  double full_well_e = 1e30;
  double dark_e_per_s = 0;
  int hot_pixels = 0;
  double hot_e_per_s = 0;  ///< dark current of a hot pixel, on top of the others'
  int adc_max_dn = 65535;
  /// Relative deviation of the signal at saturation, signed, growing in proportion to the signal: negative compresses.
  double nonlinearity_percent = 0;
  bool bloom = false;  ///< charge above the full well runs along the column, half up and half down
};

/// Which random numbers a frame uses.
struct FrameKey {
  std::uint64_t seed = 0;
  std::uint64_t number = 0;  ///< unique among the scene's frames
};

/// Electrons per pixel of a Gaussian beam, each pixel's share integrated over its square.
/// @param diameter_mm full width between the 1/e² points of irradiance, on the sensor
/// @returns rows × columns, sum `total_e` less what falls beside the sensor
Grid<double> gaussian_spot_e(const Bench& bench, const PixelPoint& centre, double diameter_mm, double total_e);

/// One raw frame. Photon and dark electrons are one Poisson draw; then full well (and blooming), non-linearity, read
/// noise, gain, bias, rounding to nearest, clipping to 0 … maximum. The same bits at any number of threads.
/// @param signal_e expected photo-electrons, rows × columns; NaN counts as 0
Grid<std::uint16_t> render_frame(const Grid<double>& signal_e, const SensorTruth& sensor, double exposure_s,
                                 const FrameKey& key);

/// Places of the hot pixels (row·columns + column), the same in every frame of a seed, ascending, no repeats.
std::vector<std::size_t> hot_pixels(const SensorTruth& sensor, std::uint64_t seed, std::size_t pixels);

}  // namespace scatmap::synth
