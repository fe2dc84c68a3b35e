#pragma once
#include <cmath>
#include <random>
#include <vector>

#include "scatmap/counts/reduce.h"

/// Frames made in the test from stated expectations: Poisson electrons, Gaussian read noise, rounding.
namespace scatmap::test {

inline const SensorModel kSensor{1.5, 8, 65535, 300, {}};

inline Frame made_frame(const Grid<double>& expected_e, double dark_e, const SensorModel& s, std::mt19937_64& rng) {
  Frame f{Grid<float>(expected_e.rows(), expected_e.columns()), 1, "made", {}};
  std::normal_distribution<double> read(0, s.read_noise_e);
  for (std::size_t i = 0; i < f.dn.size(); ++i) {
    const double mean = expected_e[i] + dark_e;
    const double electrons = mean > 0 ? static_cast<double>(std::poisson_distribution<long>(mean)(rng)) : 0;
    f.dn[i] = static_cast<float>(std::min(65535.0, std::round(s.bias_dn + (electrons + read(rng)) / s.gain_e_per_dn)));
  }
  return f;
}

inline std::vector<Frame> made_frames(int count, const Grid<double>& expected_e, double dark_e, const SensorModel& s,
                                      std::mt19937_64& rng) {
  std::vector<Frame> out;
  for (int k = 0; k < count; ++k) out.push_back(made_frame(expected_e, dark_e, s, rng));
  return out;
}

struct Moments {
  double mean = 0, sd = 0, n = 0;
};

template <class Values>
Moments moments(const Values& values) {
  double sum = 0, square = 0, n = 0;
  for (const double v : values) {
    sum += v;
    square += v * v;
    n += 1;
  }
  return {sum / n, std::sqrt(std::max(0.0, square / n - sum / n * sum / n)), n};
}

}  // namespace scatmap::test
