#pragma once
#include <array>
#include <cmath>
#include <random>

#include "tests/support/random_instrument.h"

/// The places where angle code breaks: benches drawn about each of them.
namespace scatmap::test {

inline constexpr std::array<const char*, 11> kRegimes{"random bench",     "theta_s to 0",          "theta_s to 90 deg",
                                                      "theta_h to 0",     "phi at its branch cut", "identity rotation",
                                                      "rotation near pi", "grazing detector",      "array corners",
                                                      "extreme distance", "sub-pixel steps"};

class RegimeBenches {
 public:
  explicit RegimeBenches(unsigned seed) : rng_(seed) {}
  std::mt19937_64& rng() { return rng_; }

  /// A bench of the regime, its frame at most 700 × 100 pixels unless `size` says otherwise.
  RandomBench draw(std::size_t regime) {
    RandomBench b = random_bench(rng_, regime == 0 ? within(1, 8) : 1);
    b.truth.columns = 100 + static_cast<int>(within(0, 600));
    b.truth.rows = 20 + static_cast<int>(within(0, 80));
    shape(regime, b);
    b.instrument = instrument_of(b.truth);
    return b;
  }
  double within(double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng_); }

 private:
  /// ± 10^−u: equal chances for every order of magnitude.
  double tiny(double lowest, double highest) {
    return (within(0, 1) < 0.5 ? -1 : 1) * std::pow(10, within(lowest, highest));
  }
  void straighten(synth::Bench& b) {
    b.offset_mm = {};
    b.rotation_deg = {};
    b.arm_zero_deg = b.stage_zero_deg = b.beam_elevation_deg = b.sample_tilt_deg = b.sample_height_mm = 0;
    b.axis_offset_mm = b.axis_tilt_deg = b.beam_offset_mm = {};
  }
  void shape(std::size_t regime, RandomBench& out) {
    synth::Bench& b = out.truth;
    switch (regime) {
      case 1:  // the normal points into the frame, sometimes onto a pixel to the last digit
        if (within(0, 1) < 0.5) straighten(b);
        out.arm_deg = out.stage_deg + tiny(-16, 0);
        break;
      case 2:
        out.arm_deg = out.stage_deg + (within(0, 1) < 0.5 ? -90 : 90) + tiny(-14, 0.5);
        break;
      case 3:
        if (within(0, 1) < 0.5) straighten(b);
        out.arm_deg = 2 * out.stage_deg + tiny(-14, -2);
        break;
      case 4:
        if (within(0, 1) < 0.7) straighten(b);
        out.stage_deg = std::abs(out.stage_deg);
        out.arm_deg = out.stage_deg - within(1, 80);
        break;
      case 5:
        straighten(b);
        out.stage_deg = within(0, 1) < 0.3 ? 0 : out.stage_deg;
        out.arm_deg = within(0, 1) < 0.3 ? out.stage_deg : 2 * out.stage_deg;
        break;
      case 6:
        if (within(0, 1) < 0.5)
          b.rotation_deg = {tiny(-14, 0), tiny(-14, 0), 180 + tiny(-14, 0)};
        else
          b.rotation_deg = {180 + tiny(-14, 0), 180 + tiny(-14, 0), tiny(-14, 0)};
        break;
      case 7:
        b.rotation_deg[within(0, 1) < 0.5 ? 0 : 1] = (within(0, 1) < 0.5 ? -1 : 1) * (90 - std::abs(tiny(-4, 1)));
        break;
      case 9:
        b.distance_mm = std::pow(10, within(0.3, 7));
        break;
      case 10:
        b.pitch_um = {std::pow(10, within(-7, 0)), std::pow(10, within(-7, 0))};
        break;
      default:
        break;
    }
  }
  std::mt19937_64 rng_;
};

}  // namespace scatmap::test
