#include "data-synthetic/simulate.h"

#include <algorithm>

#include "data-synthetic/scene.h"
#include "data-synthetic/write_dataset.h"
#include "scatmap/base/output_folder.h"

namespace scatmap::synth {
namespace fs = std::filesystem;

SimulateResult simulate(const fs::path& scene_file, const fs::path& out_dir, Overwrite overwrite,
                        const Provenance& provenance) {
  const std::string text = read_text_file(scene_file);
  const Scene scene = parse_scene(text, scene_file.string());
  Provenance record = provenance;
  if (record.inputs.empty()) record.inputs.push_back(record_input(scene_file));

  OutputFolder folder(out_dir, std::filesystem::path("truth") / "scene.toml", overwrite);
  write_dataset(scene, text, folder.temporary(), record);
  SimulateResult result;
  for (const auto& entry : fs::recursive_directory_iterator(folder.temporary())) {
    if (entry.is_regular_file()) result.files.push_back(out_dir / entry.path().lexically_relative(folder.temporary()));
  }
  std::sort(result.files.begin(), result.files.end());
  folder.commit();
  return result;
}

}  // namespace scatmap::synth
