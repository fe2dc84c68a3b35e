#pragma once
#include <vector>

#include "data-synthetic/truth_geometry.h"

namespace scatmap::tools {

/// A bench with its motors at rest.
struct AngleSetup {
  synth::Bench bench;
  double stage_deg = 20, arm_deg = 40;
};

struct AngleRegime {
  const char* name;
  AngleSetup setup;
};

/// Where geometry is at the ends of its range; frames are small, so that every pixel can be compared.
std::vector<AngleRegime> angle_regimes();

synth::TruthGeometry truth_of(const AngleSetup& setup);

/// Nobody can compute angles here: the beam misses the sample's front, or the sensor is edge-on to within rounding.
bool is_impossible(const AngleSetup& setup);

}  // namespace scatmap::tools
