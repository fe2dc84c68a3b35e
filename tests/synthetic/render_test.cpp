// Rendering: energy, noise, limits, blooming, and the same bits at any number of threads. Does not prove that a real
// CCD behaves so; the sensor model is the one stated in render.h.
#include "data-synthetic/render.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <numeric>
#include <set>

namespace scatmap::synth {
namespace {

Bench bench_of(int rows, int columns) {
  Bench b;
  b.columns = columns;
  b.rows = rows;
  b.pitch_um = {10, 20};
  b.distance_mm = 300;
  return b;
}

SensorTruth plain_sensor() {
  SensorTruth s;
  s.gain_e_per_dn = 1.5;
  s.read_noise_e = 8;
  s.bias_dn = 300;
  return s;
}

struct Moments {
  double mean = 0, variance = 0;
};

Moments moments(const Grid<std::uint16_t>& dn) {
  const auto n = static_cast<double>(dn.size());
  Moments out;
  for (const std::uint16_t v : dn) out.mean += v / n;
  for (const std::uint16_t v : dn) out.variance += (v - out.mean) * (v - out.mean) / (n - 1);
  return out;
}

TEST(Render, SpotKeepsItsElectrons) {
  const auto spot = gaussian_spot_e(bench_of(400, 500), {220.3L, 180.7L}, 0.8, 1e9);
  const double sum = std::accumulate(spot.begin(), spot.end(), 0.0);
  EXPECT_NEAR(sum / 1e9, 1, 1e-12);
  double column = 0, row = 0, column_square = 0, row_square = 0;
  for (int r = 0; r < 400; ++r) {
    for (int c = 0; c < 500; ++c) {
      column += c * spot(r, c) / sum;
      row += r * spot(r, c) / sum;
      column_square += c * c * spot(r, c) / sum;
      row_square += r * r * spot(r, c) / sum;
    }
  }
  EXPECT_NEAR(column, 220.3, 1e-9);
  EXPECT_NEAR(row, 180.7, 1e-9);
  // 1/e² diameter 0.8 mm: σ = 0.2 mm = 20 columns = 10 rows; a square pixel adds 1/12.
  EXPECT_NEAR(column_square - column * column, 400 + 1.0 / 12, 1e-6);
  EXPECT_NEAR(row_square - row * row, 100 + 1.0 / 12, 1e-6);
}

TEST(Render, HalfASpotOnTheEdge) {
  const auto spot = gaussian_spot_e(bench_of(400, 500), {-0.5L, 200}, 0.8, 1e9);
  EXPECT_NEAR(std::accumulate(spot.begin(), spot.end(), 0.0) / 0.5e9, 1, 1e-12);
}

TEST(Render, MeanAndVarianceOfAFlatField) {
  for (const double signal_e : {0.0, 3.0, 40.0, 3000.0, 60000.0}) {
    SensorTruth sensor = plain_sensor();
    sensor.dark_e_per_s = 2;
    const auto dn = render_frame(Grid<double>(400, 500, signal_e), sensor, 5, {3, 1});
    const Moments m = moments(dn);
    const double charge_e = signal_e + 10, variance = (charge_e + 64) / 2.25 + 1.0 / 12;
    EXPECT_NEAR(m.mean, 300 + charge_e / 1.5, 4.5 * std::sqrt(variance / 200000)) << signal_e;
    // Fourth moment: normal plus the Poisson's excess, charge/variance².
    const double kurtosis = 2 + charge_e / std::pow(charge_e + 64, 2);
    EXPECT_NEAR(m.variance / variance, 1, 4.5 * std::sqrt(kurtosis / 200000)) << signal_e;
  }
}

TEST(Render, SameBitsAtOneAndTwoThreads) {
  SensorTruth sensor = plain_sensor();
  sensor.hot_pixels = 20;
  sensor.hot_e_per_s = 1000;
  sensor.full_well_e = 2000;
  sensor.bloom = true;
  const auto spot = gaussian_spot_e(bench_of(300, 333), {150, 160}, 0.3, 3e6);
  const auto render = [&](std::size_t threads) {
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, threads);
    return render_frame(spot, sensor, 1, {42, 7});
  };
  const auto one = render(1), two = render(2), four = render(4);
  EXPECT_TRUE(std::equal(one.begin(), one.end(), two.begin()));
  EXPECT_TRUE(std::equal(one.begin(), one.end(), four.begin()));
  const auto next = render_frame(spot, sensor, 1, {42, 8});
  EXPECT_FALSE(std::equal(one.begin(), one.end(), next.begin()));
}

TEST(Render, CountsAreCutAtSaturationAndZero) {
  SensorTruth sensor = plain_sensor();
  sensor.saturation_dn = 4095;
  for (const std::uint16_t v : render_frame(Grid<double>(20, 20, 1e6), sensor, 1, {1, 1})) EXPECT_EQ(v, 4095);
  sensor.adc_max_dn = 1023;
  for (const std::uint16_t v : render_frame(Grid<double>(20, 20, 1e6), sensor, 1, {1, 1})) EXPECT_EQ(v, 1023);
  sensor.bias_dn = 0;
  const auto dark = render_frame(Grid<double>(20, 20, 0), sensor, 1, {1, 1});
  EXPECT_EQ(*std::min_element(dark.begin(), dark.end()), 0);
}

TEST(Render, NanSignalIsDark) {
  const auto dn = render_frame(Grid<double>(100, 100, std::nan("")), plain_sensor(), 1, {1, 1});
  EXPECT_NEAR(moments(dn).mean, 300, 0.3);
}

TEST(Render, FullWellWithoutReadNoiseIsExact) {
  SensorTruth sensor = plain_sensor();
  sensor.read_noise_e = 0;
  sensor.full_well_e = 30000;
  for (const std::uint16_t v : render_frame(Grid<double>(20, 20, 1e6), sensor, 1, {1, 1})) EXPECT_EQ(v, 20300);
}

TEST(Render, NonlinearityIsQuadraticAndReachesItsValueAtSaturation) {
  SensorTruth sensor = plain_sensor();
  sensor.read_noise_e = 0;
  sensor.nonlinearity_percent = -2;
  const double saturation_e = (65535 - 300) * 1.5;
  for (const double part : {0.25, 0.5, 0.9}) {
    const double signal_e = part * saturation_e;
    const double mean_dn = moments(render_frame(Grid<double>(300, 300, signal_e), sensor, 1, {5, 1})).mean;
    const double expected_dn = 300 + signal_e / 1.5 * (1 - 0.02 * part);
    EXPECT_NEAR(mean_dn, expected_dn, 5 * std::sqrt(signal_e) / 1.5 / 300 + 0.05) << part;
  }
  // Far beyond saturation a compressing sensor still reads full scale.
  sensor.full_well_e = 1e9;
  for (const std::uint16_t v : render_frame(Grid<double>(20, 20, 1e8), sensor, 1, {1, 1})) EXPECT_EQ(v, 65535);
}

TEST(Render, HotPixelsStayInPlaceAndCollectTheirCharge) {
  SensorTruth sensor = plain_sensor();
  sensor.hot_pixels = 50;
  sensor.hot_e_per_s = 3000;
  const auto places = hot_pixels(sensor, 9, 10000);
  EXPECT_EQ(std::set<std::size_t>(places.begin(), places.end()).size(), 50U);
  double sum = 0;
  const auto dn = render_frame(Grid<double>(100, 100, 0), sensor, 2, {9, 4});
  for (const std::size_t i : places) sum += dn[i] / 50.0;
  EXPECT_NEAR(sum, 300 + 6000 / 1.5, 4.5 * std::sqrt(6064.0 / 50) / 1.5);
}

TEST(Render, BloomingKeepsTheChargeInTheColumn) {
  SensorTruth sensor = plain_sensor();
  sensor.read_noise_e = 0;
  sensor.bias_dn = 0;
  sensor.gain_e_per_dn = 1;
  sensor.full_well_e = 1000;
  Grid<double> signal_e(201, 5, 0);
  signal_e(100, 2) = 20500;
  sensor.bloom = true;
  const auto bloomed = render_frame(signal_e, sensor, 1, {2, 1});
  sensor.bloom = false;
  sensor.full_well_e = 1e9;
  const auto free = render_frame(signal_e, sensor, 1, {2, 1});
  long sum = 0;
  for (int r = 0; r < 201; ++r) sum += bloomed(r, 2);
  EXPECT_NEAR(static_cast<double>(sum), free(100, 2), 2);
  for (int r = 91; r <= 109; ++r) EXPECT_EQ(bloomed(r, 2), 1000);
  EXPECT_EQ(bloomed(80, 2), 0);
  for (int r = 0; r < 201; ++r) EXPECT_EQ(bloomed(r, 1), 0);
  EXPECT_NEAR(bloomed(89, 2), bloomed(111, 2), 1);
}

}  // namespace
}  // namespace scatmap::synth
