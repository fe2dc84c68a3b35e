#pragma once
#include <string>
#include <vector>

#include "data-synthetic/scene.h"
#include "scatmap/base/provenance.h"

namespace scatmap::synth {

/// One comment line each: program, command line, inputs with checksums. Control characters become spaces.
std::string provenance_comment(const Provenance& provenance);

/// Paths of one stack's files, relative to the dataset.
struct StackFiles {
  std::vector<std::string> frames;
  std::vector<std::string> darks;
};

/// The files of design section 4. Directions of the values: instrument and measurement say what the lab believes.
std::string instrument_toml(const Bench& bench, const SensorTruth& sensor);
std::string measurement_toml(const Scene& scene, const std::vector<StackFiles>& signatures,
                             const std::vector<StackFiles>& exposures);
std::string model_toml(const ModelTruth& model);

}  // namespace scatmap::synth
