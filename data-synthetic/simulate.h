#pragma once
#include <filesystem>
#include <vector>

#include "scatmap/base/output_file.h"
#include "scatmap/base/provenance.h"

namespace scatmap::synth {

struct SimulateResult {
  std::vector<std::filesystem::path> files;  ///< everything written, in place
};

/// Renders a scene into `out_dir` as a laboratory would leave it, with the truth beside it under truth/. The folder
/// appears whole or not at all. An existing folder that is not empty is kept unless kForce, and then replaced only if
/// simulate wrote it. `provenance.inputs` may be empty: the scene file is recorded here.
/// @throws Error naming file, line and key of the scene, or the output that cannot be written
SimulateResult simulate(const std::filesystem::path& scene_file, const std::filesystem::path& out_dir,
                        Overwrite overwrite, const Provenance& provenance);

}  // namespace scatmap::synth
