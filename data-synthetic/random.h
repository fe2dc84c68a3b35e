#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace scatmap::synth {

/// The mixing function of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014; variant 13 of Stafford's mixers).
inline std::uint64_t mixed(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// The key of one frame's (or list's) random numbers. `purpose` keeps photon noise, read noise and the rest apart.
inline std::uint64_t random_key(std::uint64_t seed, std::uint64_t purpose, std::uint64_t number) {
  return mixed(mixed(mixed(seed + 0x9e3779b97f4a7c15ULL) + purpose) + number);
}

/// Layers of Marsaglia and Tsang's ziggurat for the normal density exp(−x²/2), 256 of equal area
/// (J. Stat. Softw. 5(8), 2000); the layer and the place in it come from different bits, as Doornik (2005) asks.
struct Ziggurat {
  static constexpr double kTail = 3.6541528853610088;
  std::array<double, 257> x{};
  std::array<double, 257> density{};

  Ziggurat() {
    const double at_tail = std::exp(-kTail * kTail / 2);
    const double area = kTail * at_tail + std::sqrt(std::numbers::pi / 2) * std::erfc(kTail / std::numbers::sqrt2);
    x[0] = area / at_tail;
    x[1] = kTail;
    for (std::size_t i = 2; i < 256; ++i) x[i] = std::sqrt(-2 * std::log(area / x[i - 1] + density_at(x[i - 1])));
    x[256] = 0;
    for (std::size_t i = 0; i < 257; ++i) density[i] = density_at(x[i]);
  }
  static double density_at(double v) { return std::exp(-v * v / 2); }
};
inline const Ziggurat kZiggurat;

/// Random numbers that belong to one pixel of one frame: a stretch of 1024 numbers of the SplitMix64 sequence that
/// starts at the frame's key. No state is shared, so any order and any number of threads gives the same bits.
class PixelRandom {
 public:
  PixelRandom(std::uint64_t key, std::uint64_t pixel) : state_(key + (pixel << 10) * kStep) {}

  /// Uniform in (0, 1), 53 bits.
  double uniform() { return open_unit(bits()); }

  /// Mean 0, standard deviation 1.
  double normal() {
    for (;;) {
      const std::uint64_t b = bits();
      const std::size_t layer = b & 255;
      const double z = (2 * open_unit(b) - 1) * kZiggurat.x[layer];
      if (std::fabs(z) < kZiggurat.x[layer + 1]) return z;
      if (layer == 0) return std::copysign(normal_tail(), z);
      const double low = kZiggurat.density[layer], high = kZiggurat.density[layer + 1];
      if (low + uniform() * (high - low) < Ziggurat::density_at(z)) return z;
    }
  }

  /// A whole number, kept as double. Exact for every mean up to 2^53: inversion below 10, Hörmann's PTRS above
  /// (Insurance: Mathematics and Economics 12, 39, 1993). 0 when the mean is 0, negative or NaN.
  double poisson(double mean) {
    if (!(mean > 0)) return 0;
    return mean < 10 ? poisson_by_inversion(mean) : poisson_by_rejection(mean);
  }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ULL;

  std::uint64_t bits() { return mixed(state_ += kStep); }
  static double open_unit(std::uint64_t b) { return (static_cast<double>(b >> 11) + 0.5) * 0x1p-53; }

  double normal_tail() {
    for (;;) {
      const double x = -std::log(uniform()) / Ziggurat::kTail;
      if (-2 * std::log(uniform()) > x * x) return Ziggurat::kTail + x;
    }
  }

  double poisson_by_inversion(double mean) {
    const double u = uniform();
    double probability = std::exp(-mean), sum = probability, k = 0;
    // Below 10 the chance of 100 is under 1e-60; the limit ends the search when rounding keeps the sum below u.
    while (u > sum && k < 100) {
      probability *= mean / ++k;
      sum += probability;
    }
    return k;
  }

  double poisson_by_rejection(double mean) {
    const double b = 0.931 + 2.53 * std::sqrt(mean), a = -0.059 + 0.02483 * b;
    const double quick = 0.9277 - 3.6224 / (b - 2);
    for (;;) {
      const double u = uniform() - 0.5, v = uniform();
      const double edge = 0.5 - std::fabs(u);
      const double k = std::floor((2 * a / edge + b) * u + mean + 0.43);
      if (edge >= 0.07 && v <= quick) return k;
      if (k < 0 || (edge < 0.013 && v > edge)) continue;
      const double inverse_alpha = 1.1239 + 1.1328 / (b - 3.4);
      int sign = 0;
      const double log_probability = k * std::log(mean) - mean - lgamma_r(k + 1, &sign);
      if (std::log(v * inverse_alpha / (a / (edge * edge) + b)) <= log_probability) return k;
    }
  }

  std::uint64_t state_;
};

}  // namespace scatmap::synth
