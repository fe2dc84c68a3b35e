// Angles of one pixel through the installed headers and libraries.
#include <scatmap/angles/angle_map.h>
#include <scatmap/report/map_fits.h>

#include <cmath>
#include <cstdio>

int main() {
  const scatmap::Instrument bench = scatmap::parse_instrument(
      "[detector]\ncolumns = 3\nrows = 3\npitch_um = [5.5, 5.5]\ndistance_mm = 325\n", "bench");
  const scatmap::PixelAngles a = scatmap::pixel_angles(scatmap::sample_view(bench, {0.35, 0.70}), 1, 1);
  std::printf("%.17g\n", a.theta_s_rad);
  return std::abs(a.theta_s_rad - 0.35) <= 1e-14 ? 0 : 1;
}
