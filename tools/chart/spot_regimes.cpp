#include "tools/chart/spot_regimes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "scatmap/counts/dark.h"

namespace scatmap::tools {
namespace {

template <class Change>
SpotScene with(Change change) {
  SpotScene s;
  change(s, s.spots.front());
  return s;
}

SpotScene of_flux(double electrons) {
  return with([&](SpotScene&, SpotLight& l) { l.flux_e = electrons; });
}

// In a frame that holds it, at `fraction` of a pixel from a pixel's centre.
SpotScene of_width(double sd_px, double column_fraction, double row_fraction) {
  return with([&](SpotScene& s, SpotLight& l) {
    s.columns = s.rows = std::max(48, static_cast<int>(std::lround(14 * sd_px)));
    l.major_px = l.minor_px = sd_px;
    l.column_px = s.columns / 2 + column_fraction;
    l.row_px = s.rows / 2 + row_fraction;
  });
}

SpotScene at(double column, double row) {
  return with([&](SpotScene&, SpotLight& l) {
    l.column_px = column;
    l.row_px = row;
  });
}

SpotScene pair_of(double distance_sds, double second_share) {
  return with([&](SpotScene& s, SpotLight& l) {
    SpotLight other = l;
    other.column_px += distance_sds * l.major_px * 0.8;
    other.row_px += distance_sds * l.major_px * 0.6;
    other.flux_e *= second_share;
    s.spots.push_back(other);
  });
}

SpotScene shaped(SpotLight::Shape shape, double major_px, double minor_px, double angle_rad = 0) {
  return with([&](SpotScene& s, SpotLight& l) {
    s.columns = s.rows = 96;
    l = {shape, 47.8, 48.3, 1e5, major_px, minor_px, angle_rad};
  });
}

SpotScene sloped(double e_per_px, double electrons) {
  return with([&](SpotScene& s, SpotLight& l) {
    l.flux_e = electrons;
    s.background_e = 400;
    s.slope_e_per_px = {e_per_px, -0.5 * e_per_px};
  });
}

SpotScene replaced(std::vector<SpotScene::Pixel> pixels) {
  return with([&](SpotScene& s, SpotLight&) { s.replaced = std::move(pixels); });
}

SpotScene every(double dn) {
  return with([&](SpotScene& s, SpotLight&) { s.every_dn = dn; });
}

SpotScene sized(int columns, int rows) {
  return with([&](SpotScene& s, SpotLight& l) {
    s.columns = columns;
    s.rows = rows;
    l.column_px = 0.5 * (columns - 1) + 0.2;
    l.row_px = 0.5 * (rows - 1) + 0.1;
  });
}

std::vector<SpotRegime> light_regimes() {
  using enum SpotExpectation;
  return {
      {"plain, 1e5 electrons, width 1.7 px", of_flux(1e5)},
      {"1e2 electrons", of_flux(1e2), kEither},
      {"3e2 electrons", of_flux(3e2), kEither},
      {"1e3 electrons", of_flux(1e3)},
      {"1e4 electrons", of_flux(1e4)},
      {"1e6 electrons", of_flux(1e6)},
      {"1e7 electrons", of_flux(1e7)},
      {"width 0.3 px, at a pixel's centre", of_width(0.3, 0, 0), kEither},
      {"width 0.3 px, at a pixel's corner", of_width(0.3, 0.5, 0.5), kEither},
      {"width 0.5 px, at a pixel's centre", of_width(0.5, 0, 0)},
      {"width 0.5 px, at a pixel's edge", of_width(0.5, 0.5, 0)},
      {"width 0.5 px, at a pixel's corner", of_width(0.5, 0.5, 0.5)},
      {"width 1 px, at a pixel's edge", of_width(1, 0.5, 0)},
      {"width 5 px, at a pixel's corner", of_width(5, 0.5, 0.5)},
      {"width 20 px", of_width(20, 0.2, -0.3)},
      {"without noise", with([](SpotScene& s, SpotLight&) { s.noise = false; })},
  };
}

std::vector<SpotRegime> place_regimes() {
  using enum SpotExpectation;
  return {
      {"touches the border", at(3.6, 23.6)},
      {"half off the frame", at(-0.5, 23.6), kEither},
      {"a quarter in a corner of the frame", at(-0.5, -0.5), kEither},
      {"centre 2 widths beyond the edge", at(-3.9, 23.6), kEither},
      {"two equal spots 1.5 widths apart", pair_of(1.5, 1)},
      {"two equal spots 3 widths apart", pair_of(3, 1)},
      {"two equal spots 6 widths apart", pair_of(6, 1)},
      {"1.5 widths from one of a tenth", pair_of(1.5, 0.1)},
      {"1 width from an equal one: one spot", pair_of(1, 1), kFound, true},
      {"1 width from one of a tenth: one spot", pair_of(1, 0.1), kFound, true},
      {"2 widths from one of a third", pair_of(2, 0.3)},
      {"2 widths from one of a hundredth", pair_of(2, 0.01)},
      {"3 widths from one of a tenth", pair_of(3, 0.1)},
      {"3 widths from one of a hundredth", pair_of(3, 0.01)},
      {"elongated 10 : 1", shaped(SpotLight::Shape::kGaussian, 10, 1)},
      {"elongated 10 : 1, turned by 30 deg", shaped(SpotLight::Shape::kGaussian, 10, 1, 0.5)},
      {"flat-topped, radius 6 px", shaped(SpotLight::Shape::kFlatTop, 6, 6)},
      {"ring of radius 6 px", shaped(SpotLight::Shape::kRing, 6, 1.2), kEither},
  };
}

std::vector<SpotRegime> camera_regimes() {
  using enum SpotExpectation;
  return {
      {"core saturated", with([](SpotScene& s, SpotLight& l) {
         l.flux_e = 1e6;
         s.saturation_dn = 10000;
       })},
      {"hot pixel beside the spot", replaced({{31, 24, 60000}})},
      {"hot pixel within the spot", replaced({{25, 24, 60000}})},
      {"faint hot pixel on the spot's flank", replaced({{26, 24, 3400}})},
      {"dead pixel within the spot", replaced({{25, 24, 300}})},
      {"weak pixel on the spot's flank", replaced({{26, 24, 1500}})},
      {"NaN within the spot", replaced({{25, 24, NAN}, {24, 23, NAN}})},
      {"background sloped by 0.3 e per px", sloped(0.3, 1e5)},
      {"background sloped by 1 e per px", sloped(1, 1e5)},
      {"background sloped by 3 e per px", sloped(3, 1e5)},
      {"background sloped by 10 e per px", sloped(10, 1e5)},
      {"faint spot, background sloped by 1 e per px", sloped(1, 3e3), kEither},
      {"faint spot, background sloped by 3 e per px", sloped(3, 3e3), kEither},
      {"no dark, background 200 e", with([](SpotScene& s, SpotLight&) {
         s.background_e = 200;
         s.dark_dn.reset();
       })},
      {"dark above the background", with([](SpotScene& s, SpotLight&) { s.dark_dn = 400; })},
      {"dark above the spot", with([](SpotScene& s, SpotLight&) { s.dark_dn = 20000; })},
      {"frame of one pixel", sized(1, 1), kNone},
      {"frame of one row", sized(48, 1), kNone},
      {"frame of 3 x 3 pixels", sized(3, 3), kNone},
      {"all zeros", every(0), kNone},
      {"all at the dark's level", every(300), kNone},
      {"all saturated", every(1e7), kNone},
      {"all NaN", every(NAN), kNone},
      {"noise alone", of_flux(0), kNone},
      {"gain 0", with([](SpotScene& s, SpotLight&) { s.gain_e_per_dn = 0; }), kNone},
      {"gain 1e-3", with([](SpotScene& s, SpotLight&) {
         s.gain_e_per_dn = 1e-3;
         s.saturation_dn = 1e9;
       })},
  };
}

// Light per square pixel, unit flux but for the shape's own norm.
double density(const SpotLight& l, double column, double row) {
  const double x = column - l.column_px, y = row - l.row_px, r = std::hypot(x, y);
  switch (l.shape) {
    case SpotLight::Shape::kFlatTop: {
      constexpr double kPower8Area = 0.9064024770554771;  // Γ(1.25): ∫ exp(−r⁸) 2πr dr = π Γ(1.25)
      return std::exp(-std::pow(r / l.major_px, 8)) / (std::numbers::pi * kPower8Area * l.major_px * l.major_px);
    }
    case SpotLight::Shape::kRing: {
      const double z = (r - l.major_px) / l.minor_px;
      return std::exp(-0.5 * z * z) /
             (2 * std::numbers::pi * l.major_px * l.minor_px * std::sqrt(2 * std::numbers::pi));
    }
    case SpotLight::Shape::kGaussian:
      break;
  }
  const double c = std::cos(l.angle_rad), s = std::sin(l.angle_rad);
  const double u = (c * x + s * y) / l.major_px, v = (c * y - s * x) / l.minor_px;
  return std::exp(-0.5 * (u * u + v * v)) / (2 * std::numbers::pi * l.major_px * l.minor_px);
}

// Simpson's rule over the pixel.
double on_pixel(const SpotLight& l, int column, int row) {
  constexpr int kSteps = 8;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const auto weight = [](int k) { return k == 0 || k == kSteps ? 1.0 : k % 2 == 1 ? 4.0 : 2.0; };
      sum += weight(i) * weight(j) *
             density(l, column - 0.5 + static_cast<double>(i) / kSteps, row - 0.5 + static_cast<double>(j) / kSteps);
    }
  }
  return l.flux_e * sum / (9.0 * kSteps * kSteps);
}

}  // namespace

std::vector<SpotRegime> spot_regimes() {
  std::vector<SpotRegime> out = light_regimes();
  for (const auto& more : {place_regimes(), camera_regimes()}) out.insert(out.end(), more.begin(), more.end());
  return out;
}

Grid<double> expected_light_e(const SpotScene& s) {
  Grid<double> out(s.rows, s.columns);
  for (int r = 0; r < s.rows; ++r) {
    for (int c = 0; c < s.columns; ++c) {
      double e = s.background_e + s.slope_e_per_px[0] * (c - 0.5 * (s.columns - 1)) +
                 s.slope_e_per_px[1] * (r - 0.5 * (s.rows - 1));
      for (const SpotLight& l : s.spots) {
        const double reach = 9 * (l.major_px + l.minor_px) + 2;
        if (std::hypot(c - l.column_px, r - l.row_px) < reach) e += on_pixel(l, c, r);
      }
      out(r, c) = e;
    }
  }
  return out;
}

Frame exposed(const SpotScene& s, const Grid<double>& light_e, std::uint64_t seed) {
  Frame frame{Grid<float>(s.rows, s.columns), 0, "simulated", {}};
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < light_e.size(); ++i) {
    const double noise =
        s.noise ? std::sqrt(std::max(light_e[i], 0.0) + s.read_noise_e * s.read_noise_e) * normal(rng) : 0;
    const double gain = s.gain_e_per_dn > 0 ? s.gain_e_per_dn : 1;
    const double dn = s.every_dn.value_or(s.bias_dn + (light_e[i] + noise) / gain);
    frame.dn[i] = static_cast<float>(dn > s.saturation_dn ? s.saturation_dn : dn);
  }
  for (const SpotScene::Pixel& p : s.replaced) frame.dn(p.row, p.column) = static_cast<float>(p.value_dn);
  return frame;
}

calib::SpotsInFrame measured(const SpotScene& s, const Frame& frame, calib::SpotMethod method) {
  const SensorModel sensor{s.gain_e_per_dn, s.read_noise_e, s.saturation_dn, s.bias_dn, {}};
  std::optional<MasterDark> dark;
  if (s.dark_dn) dark = stated_dark(*s.dark_dn, 0, s.rows, s.columns, 1, sensor);
  return calib::find_spots(calib::spot_image(frame, dark, sensor), method);
}

}  // namespace scatmap::tools
