#include "data-synthetic/render.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "data-synthetic/random.h"
#include "data-synthetic/random_purpose.h"
#include "scatmap/base/parallel.h"

namespace scatmap::synth {
namespace {

// Share of a Gaussian that falls on each pixel of one axis.
std::vector<double> gaussian_shares(int pixels, double centre_px, double sigma_px) {
  const auto below = [&](double edge_px) {
    return std::erfc(-(edge_px - centre_px) / (std::numbers::sqrt2 * sigma_px)) / 2;
  };
  std::vector<double> shares(static_cast<std::size_t>(pixels));
  for (int i = 0; i < pixels; ++i) shares[static_cast<std::size_t>(i)] = below(i + 0.5) - below(i - 0.5);
  return shares;
}

// Electrons in the wells when the shutter closes, before any limit. Float is exact beyond any full well.
Grid<float> collected_e(const Grid<double>& signal_e, const SensorTruth& sensor, double exposure_s,
                        const FrameKey& key) {
  const std::uint64_t random = random_key(key.seed, kPhotons, key.number);
  const double dark_e = sensor.dark_e_per_s * exposure_s;
  const auto draw = [&](std::size_t i, double thermal_e) {
    const double light_e = std::isnan(signal_e[i]) ? 0 : signal_e[i];
    return static_cast<float>(PixelRandom(random, i).poisson(light_e + thermal_e));
  };
  Grid<float> out(signal_e.rows(), signal_e.columns());
  const auto columns = static_cast<std::size_t>(signal_e.columns());
  for_each_row(out.rows(), [&](int r) {
    const std::size_t first = static_cast<std::size_t>(r) * columns;
    for (std::size_t i = first; i < first + columns; ++i) out[i] = draw(i, dark_e);
  });
  const double hot_e = dark_e + sensor.hot_e_per_s * exposure_s;
  for (const std::size_t i : hot_pixels(sensor, key.seed, out.size())) out[i] = draw(i, hot_e);
  return out;
}

// Moves the excess of every pixel of a column one way, until it finds room or runs off the edge.
void spill(std::vector<double>& column, double full_well_e, std::vector<double> excess) {
  double carried = 0;
  for (std::size_t i = 0; i < column.size(); ++i) {
    const double room = full_well_e - column[i];
    const double taken = std::min(std::max(room, 0.0), carried);
    column[i] += taken;
    carried += excess[i] - taken;
  }
}

void bloom_column(Grid<float>& charge_e, int c, double full_well_e) {
  const auto rows = static_cast<std::size_t>(charge_e.rows());
  std::vector<double> column(rows), excess(rows);
  bool any = false;
  for (std::size_t r = 0; r < rows; ++r) {
    const double e = static_cast<double>(charge_e(static_cast<int>(r), c));
    column[r] = std::min(e, full_well_e);
    excess[r] = (e - column[r]) / 2;
    any = any || excess[r] > 0;
  }
  if (!any) return;
  spill(column, full_well_e, excess);
  std::reverse(column.begin(), column.end());
  std::reverse(excess.begin(), excess.end());
  spill(column, full_well_e, excess);
  for (std::size_t r = 0; r < rows; ++r) charge_e(static_cast<int>(r), c) = static_cast<float>(column[rows - 1 - r]);
}

Grid<std::uint16_t> digitised(const Grid<float>& charge_e, const SensorTruth& sensor, const FrameKey& key) {
  const std::uint64_t random = random_key(key.seed, kReadNoise, key.number);
  const double largest_dn = std::floor(std::min(sensor.saturation_dn, static_cast<double>(sensor.adc_max_dn)));
  const double saturation_e = (largest_dn - sensor.bias_dn) * sensor.gain_e_per_dn;
  const double bend_per_e = sensor.nonlinearity_percent / 100 / saturation_e;
  Grid<std::uint16_t> out(charge_e.rows(), charge_e.columns());
  const auto columns = static_cast<std::size_t>(out.columns());
  for_each_row(out.rows(), [&](int r) {
    const std::size_t first = static_cast<std::size_t>(r) * columns;
    for (std::size_t i = first; i < first + columns; ++i) {
      const double e = std::min(static_cast<double>(charge_e[i]), sensor.full_well_e);
      // Beyond saturation the bend stays as it is, so that more light never reads as less.
      const double bent_e = e * (1 + bend_per_e * std::min(e, saturation_e));
      const double read_e = bent_e + sensor.read_noise_e * PixelRandom(random, i).normal();
      const double dn = std::floor(sensor.bias_dn + read_e / sensor.gain_e_per_dn + 0.5);
      out[i] = static_cast<std::uint16_t>(std::clamp(dn, 0.0, largest_dn));
    }
  });
  return out;
}

}  // namespace

Grid<double> gaussian_spot_e(const Bench& bench, const PixelPoint& centre, double diameter_mm, double total_e) {
  // The irradiance exp(−2r²/w²) falls to 1/e² at r = w, so a standard deviation is a quarter of the diameter.
  const double sigma_um = diameter_mm * 1000 / 4;
  const auto across =
      gaussian_shares(bench.columns, static_cast<double>(centre.column_px), sigma_um / bench.pitch_um[0]);
  const auto down = gaussian_shares(bench.rows, static_cast<double>(centre.row_px), sigma_um / bench.pitch_um[1]);
  Grid<double> out(bench.rows, bench.columns);
  for_each_row(out.rows(), [&](int r) {
    const double row_e = total_e * down[static_cast<std::size_t>(r)];
    for (int c = 0; c < out.columns(); ++c) out(r, c) = row_e * across[static_cast<std::size_t>(c)];
  });
  return out;
}

std::vector<std::size_t> hot_pixels(const SensorTruth& sensor, std::uint64_t seed, std::size_t pixels) {
  std::set<std::size_t> found;
  const auto wanted = std::min(static_cast<std::size_t>(sensor.hot_pixels), pixels / 2);
  PixelRandom random(random_key(seed, kHotPixels, 0), 0);
  while (found.size() < wanted) found.insert(static_cast<std::size_t>(random.uniform() * static_cast<double>(pixels)));
  return {found.begin(), found.end()};
}

Grid<std::uint16_t> render_frame(const Grid<double>& signal_e, const SensorTruth& sensor, double exposure_s,
                                 const FrameKey& key) {
  Grid<float> charge_e = collected_e(signal_e, sensor, exposure_s, key);
  if (sensor.bloom) {
    for_each_index(charge_e.columns(), 1, [&](int c) { bloom_column(charge_e, c, sensor.full_well_e); });
  }
  return digitised(charge_e, sensor, key);
}

}  // namespace scatmap::synth
