#include "tools/chart/brdf_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "scatmap/base/parallel.h"

namespace scatmap::tools {
namespace {

constexpr int kDarks = 3;
constexpr double kHotShare = 1e-4;

std::uint64_t mixed(std::uint64_t x) {  // splitmix64: the same noise on every machine
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

// Nearly normal, mean 0, standard deviation 1: four uniform numbers of 16 bits summed.
double noise(std::uint64_t seed) {
  const std::uint64_t bits = mixed(seed);
  double sum = 0;
  for (unsigned k = 0; k < 64; k += 16) sum += static_cast<double>((bits >> k) & 0xffff) / 65535.0;
  return (sum - 2) * std::sqrt(3.0);
}

double expected_e(double x, double y) {  // x, y: −1 to 1 across the frame
  const double r2 = x * x + y * y;
  return 8 + 4e3 * std::exp(-r2 / 0.05) + 3e5 * std::exp(-r2 / 2e-4) + 40 * (1 + std::cos(60 * y));
}

Frame made_frame(int rows, int columns, const SensorModel& s, bool dark, std::uint64_t number) {
  Grid<std::uint16_t> dn(rows, columns);  // as cameras give them
  for_each_row(rows, [&](int r) {
    for (int c = 0; c < columns; ++c) {
      const auto i =
          static_cast<std::uint64_t>(r) * static_cast<std::uint64_t>(columns) + static_cast<std::uint64_t>(c);
      const bool hot = static_cast<double>(mixed(i) >> 11) * 0x1p-53 < kHotShare;
      const double signal_e = dark ? 0 : expected_e(2.0 * c / columns - 1, 2.0 * r / rows - 1);
      const double mean_e = signal_e + (hot ? 2e4 : 4);
      const double e = mean_e + noise(i * 64 + number) * std::sqrt(mean_e + s.read_noise_e * s.read_noise_e);
      dn(r, c) = static_cast<std::uint16_t>(std::clamp(std::round(s.bias_dn + e / s.gain_e_per_dn), 0.0, 65535.0));
    }
  });
  return {std::move(dn), 1, "made in memory", {}};
}

// The paper's 17 geometry parameters as a calibration might leave them.
Calibration calibration_of_17() {
  Calibration out;
  for (const GeometryKey& key : geometry_keys()) {
    if (std::string(key.name).starts_with("detector.pitch_um")) continue;
    out.parameters.emplace_back(key.name);
  }
  const auto n = static_cast<Eigen::Index>(out.parameters.size());
  out.covariance = Eigen::MatrixXd::Identity(n, n) * 1e-6;
  for (Eigen::Index i = 0; i + 1 < n; ++i) out.covariance(i, i + 1) = out.covariance(i + 1, i) = 3e-7;
  return out;
}

}  // namespace

BrdfScene brdf_scene(const Instrument& instrument, const Pose& pose, int frames) {
  BrdfScene s{instrument, pose, {}, {}, {1.5, 8, 65535, 300, {}}, {}};
  s.instrument.calibration = calibration_of_17();
  std::vector<Frame> darks;
  std::uint64_t number = 0;
  for (int k = 0; k < kDarks; ++k)
    darks.push_back(made_frame(instrument.rows, instrument.columns, s.sensor, true, number++));
  s.dark = combine_darks(darks, s.sensor);
  for (int k = 0; k < frames; ++k)
    s.frames.push_back(made_frame(instrument.rows, instrument.columns, s.sensor, false, number++));
  return s;
}

}  // namespace scatmap::tools
