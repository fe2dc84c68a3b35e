// The TAN world coordinates against the pixel angles, through the FITS paper's own chain (Calabretta & Greisen 2002:
// intermediate coordinates, native angles, spherical rotation Eq. 2), written out here in long double.
// Does not prove that a viewer implements that chain; astropy's wcslib is checked by tests/interop.sh.
#include "scatmap/angles/tan_wcs.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scatmap/angles/angle_map.h"
#include "tests/support/random_instrument.h"

namespace scatmap {
namespace {

constexpr double kWcsMaxError_rad = 1e-12;

struct World {
  long double longitude_rad, latitude_rad;
};

World world(const TanWcs& w, long double column, long double row) {
  constexpr long double kDeg = std::numbers::pi_v<long double> / 180;
  const long double p1 = column + 1 - w.crpix[0], p2 = row + 1 - w.crpix[1];
  const long double x = w.cd[0][0] * p1 + w.cd[0][1] * p2, y = w.cd[1][0] * p1 + w.cd[1][1] * p2;
  const long double native_longitude = std::atan2(x, -y), native_latitude = std::atan2(1.0L, std::hypot(x, y) * kDeg);
  const long double pole_latitude = w.crval_deg[1] * kDeg, turn = native_longitude - TanWcs::kLonPole_deg * kDeg;
  const long double st = std::sin(native_latitude), ct = std::cos(native_latitude), sp = std::sin(pole_latitude),
                    cp = std::cos(pole_latitude);
  const long double longitude =
      w.crval_deg[0] * kDeg + std::atan2(-ct * std::sin(turn), st * cp - ct * sp * std::cos(turn));
  const long double z = st * sp + ct * cp * std::cos(turn);
  const long double in_plane = std::hypot(st * cp - ct * sp * std::cos(turn), ct * std::sin(turn));
  return {longitude, std::atan2(z, in_plane)};
}

TEST(TanWcs, GivesThePixelAngles) {
  std::mt19937_64 rng(11);
  int compared = 0;
  for (int i = 0; i < 200; ++i) {
    const auto bench = test::random_bench(rng, 1 + i % 5);
    const SampleView view = sample_view(bench.instrument, bench.pose());
    const TanWcs wcs = tan_wcs(view);
    for (int k = 0; k < 20; ++k) {
      const double column = static_cast<double>(rng() % 3000), row = static_cast<double>(rng() % 2000);
      const PixelAngles a = pixel_angles(view, column, row);
      if (a.mask != 0) continue;
      const World w = world(wcs, column, row);
      EXPECT_LE(std::abs(std::numbers::pi_v<long double> / 2 - w.latitude_rad - a.theta_s_rad), kWcsMaxError_rad);
      EXPECT_LE(std::abs(std::remainder(w.longitude_rad - a.phi_s_rad, 2 * std::numbers::pi_v<long double>)) *
                    std::sin(a.theta_s_rad),
                kWcsMaxError_rad);
      ++compared;
    }
  }
  EXPECT_GE(compared, 2000);
}

TEST(TanWcs, DetectorSquareOnTheSampleNormal) {
  Instrument in;
  in.columns = in.rows = 11;
  in.geometry.pixel_column = in.geometry.pixel_row = 1e-3;
  in.geometry.distance = 0.1;
  const SampleView view =
      sample_view(in, {0.3, 0.3});  // looks along the normal: the pole of the world is the pixel (5, 5)
  const TanWcs wcs = tan_wcs(view);
  EXPECT_NEAR(wcs.crpix[0], 6, 1e-9);
  for (const auto& [column, row] : {std::pair{7.0, 5.0}, {5.0, 8.0}, {1.0, 2.0}}) {
    const PixelAngles a = pixel_angles(view, column, row);
    const World w = world(wcs, column, row);
    EXPECT_LE(std::abs(std::numbers::pi_v<long double> / 2 - w.latitude_rad - a.theta_s_rad), kWcsMaxError_rad);
    EXPECT_LE(std::abs(std::remainder(w.longitude_rad - a.phi_s_rad, 2 * std::numbers::pi_v<long double>)),
              kWcsMaxError_rad);
  }
}

}  // namespace
}  // namespace scatmap
