#pragma once
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "scatmap/angles/instrument.h"
#include "scatmap/base/provenance.h"
#include "scatmap/base/units.h"

namespace scatmap::tools {

/// An instrument file and what it names: its lens model. @throws Error if one of them cannot be read
inline std::vector<InputRecord> instrument_inputs(const std::filesystem::path& file, const Instrument& instrument) {
  std::vector<InputRecord> out{record_input(file)};
  if (instrument.lens_cameramodel) out.push_back(record_input(*instrument.lens_cameramodel));
  return out;
}

/// A detector that looks impossibly large or small from the spot: most likely a number in other units. Tells on stderr.
inline void note_odd_size(const std::filesystem::path& file, const Instrument& in) {
  constexpr double kSmallest = 1e-3, kLargest = 2;  // across, over its distance
  const Geometry<double>& g = in.geometry;
  const double across_m = std::hypot(in.columns * g.pixel_column, in.rows * g.pixel_row);
  if (in.lens_cameramodel || in.columns * in.rows < 64) return;
  if (across_m >= kSmallest * g.distance && across_m <= kLargest * g.distance) return;
  std::fprintf(stderr,
               "note: %s describes a detector of %.3g mm across at %.3g mm: are the units of pitch_um and "
               "distance_mm right?\n",
               file.c_str(), across_m / kMetrePerMm, g.distance / kMetrePerMm);
}

}  // namespace scatmap::tools
