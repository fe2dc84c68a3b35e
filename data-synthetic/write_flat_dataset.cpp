#include <algorithm>

#include "data-synthetic/random.h"
#include "data-synthetic/random_purpose.h"
#include "data-synthetic/write_dataset.h"
#include "data-synthetic/write_frames.h"

namespace scatmap::synth {
namespace {

// Electrons per second: the light's falloff times the pixels' gains.
Grid<double> light_e_per_s(const Scene& scene) {
  const FlatScene& flats = *scene.flats;
  const int rows = scene.bench.rows, columns = scene.bench.columns;
  const double middle_row = 0.5 * (rows - 1), middle_column = 0.5 * (columns - 1);
  const double corner2 = std::max(1.0, middle_row * middle_row + middle_column * middle_column);
  const std::uint64_t key = random_key(scene.seed, kPixelGains, 0);
  Grid<double> out(rows, columns);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const double y = r - middle_row, x = c - middle_column;
      const double light = 1 - flats.falloff_percent / 100 * (x * x + y * y) / corner2;
      PixelRandom random(
          key, static_cast<std::uint64_t>(r) * static_cast<std::uint64_t>(columns) + static_cast<std::uint64_t>(c));
      out(r, c) = flats.electrons_per_s * light * (1 + flats.prnu_percent / 100 * random.normal());
    }
  }
  return out;
}

}  // namespace

void write_flat_dataset(const Scene& scene, const std::filesystem::path& folder, const Provenance& provenance) {
  const FlatScene& flats = *scene.flats;
  const Grid<double> light = light_e_per_s(scene);
  FrameWriter writer(scene, folder, provenance);
  int level = 0;
  for (const double exposure_s : flats.exposure_s) {
    Grid<double> signal_e = light;
    for (double& e : signal_e) e *= exposure_s;
    writer.write_stack("flat" + std::to_string(++level), signal_e,
                       {exposure_s, exposure_s, flats.frames, flats.darks, {}, {}}, 0, 0, "Flat Field");
  }
}

}  // namespace scatmap::synth
