#pragma once
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "scatmap/base/units.h"
#include "scatmap/brdf/brdf_map.h"

/// Maps with known content, written as functions of the pixel, so that nothing of the library's models enters.
namespace scatmap::synthetic {

using Field = std::function<double(double column, double row)>;

/// A bare CCD of 13.5 um pixels, 325 mm from the spot, at the specular angle of 20 degrees incidence.
inline BrdfMap empty_map(int columns, int rows, double theta_i_deg = 20) {
  BrdfMap map;
  map.instrument.columns = columns;
  map.instrument.rows = rows;
  map.instrument.geometry.distance = 0.325;
  map.instrument.geometry.pixel_column = map.instrument.geometry.pixel_row = 13.5e-6;
  map.pose = {theta_i_deg * kRadPerDeg, 2 * theta_i_deg * kRadPerDeg};
  map.wavelength_m = 632.8e-9;
  map.mask = Grid<Mask>(rows, columns, Mask{0});
  map.brdf_per_sr = Grid<double>(rows, columns, 0.0);
  return map;
}

inline BrdfMap noiseless(int columns, int rows, const Field& field, double theta_i_deg = 20) {
  BrdfMap map = empty_map(columns, rows, theta_i_deg);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) map.brdf_per_sr(r, c) = field(c, r);
  }
  return map;
}

/// Gaussian noise of sigma² = gain·f + floor², stated exactly in u_random.
inline BrdfMap noisy(int columns, int rows, const Field& field, double gain, double floor, unsigned seed) {
  BrdfMap map = noiseless(columns, rows, field);
  map.u_random_per_sr = Grid<float>(rows, columns);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < map.brdf_per_sr.size(); ++i) {
    const auto u = static_cast<float>(std::sqrt(gain * map.brdf_per_sr[i] + floor * floor));
    map.u_random_per_sr[i] = u;
    map.brdf_per_sr[i] += static_cast<double>(u) * normal(random);
  }
  return map;
}

struct Lobe {
  double column, row, height, radius;
  double operator()(double c, double r) const {
    const double x = (c - column) / radius, y = (r - row) / radius;
    return height * std::exp(-x * x - y * y);
  }
};

/// cos² fringes of a period along a line through (column, row) at an angle from +columns towards +rows; a Gaussian
/// across it whose ridge bends away by bend·along².
struct Comb {
  double column, row, axis_deg, period, height, radius, bend = 0;
  double decay_length = 1e9;  ///< heights fall as exp(−|along|/decay_length)
  double operator()(double c, double r) const {
    const double a = axis_deg * std::numbers::pi / 180;
    const double along = (c - column) * std::cos(a) + (r - row) * std::sin(a);
    const double across = -(c - column) * std::sin(a) + (r - row) * std::cos(a) - bend * along * along;
    const double fringe = std::cos(std::numbers::pi * along / period);
    return height * fringe * fringe * std::exp(-across * across / (radius * radius) - std::abs(along) / decay_length);
  }
};

}  // namespace scatmap::synthetic
