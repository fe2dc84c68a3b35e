#pragma once
#include <filesystem>
#include <vector>

#include "scatmap/angles/instrument.h"
#include "scatmap/base/provenance.h"

namespace scatmap::tools {

/// An instrument file and what it names: its lens model. @throws Error if one of them cannot be read
inline std::vector<InputRecord> instrument_inputs(const std::filesystem::path& file, const Instrument& instrument) {
  std::vector<InputRecord> out{record_input(file)};
  if (instrument.lens_cameramodel) out.push_back(record_input(*instrument.lens_cameramodel));
  return out;
}

}  // namespace scatmap::tools
