#include "data-synthetic/write_dataset.h"

#include "data-synthetic/write_toml.h"
#include "scatmap/base/output_file.h"

namespace scatmap::synth {
namespace fs = std::filesystem;

bool on_sensor(const Bench& bench, const PixelPoint& point) {
  return point.column_px >= -0.5L && point.column_px <= bench.columns - 0.5L && point.row_px >= -0.5L &&
         point.row_px <= bench.rows - 0.5L;
}

void write_dataset(const Scene& scene, const std::string& scene_text, const fs::path& folder,
                   const Provenance& provenance) {
  fs::create_directory(folder / "truth");
  const std::string comment = provenance_comment(provenance);
  const std::string believed = instrument_toml(scene.nominal_bench, scene.nominal_sensor);
  write_text_file(folder / "instrument.toml", comment + "# What the lab believes.\n\n" + believed, Overwrite::kKeep);
  const std::string real = instrument_toml(scene.bench, scene.sensor);
  write_text_file(folder / "truth/instrument.toml", comment + "# The truth.\n\n" + real, Overwrite::kKeep);
  write_text_file(folder / "truth/scene.toml", scene_text, Overwrite::kKeep);
  if (scene.brdf) write_brdf_dataset(scene, folder, provenance);
  if (scene.mirror) write_mirror_dataset(scene, folder, provenance);
  if (scene.flats) write_flat_dataset(scene, folder, provenance);
}

}  // namespace scatmap::synth
