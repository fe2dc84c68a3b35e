#pragma once
#include <optional>
#include <string>

#include "data-synthetic/truth_geometry.h"
#include "tools/chart/chart.h"

namespace scatmap::tools {

/// The paper's solar cell at 20 deg on its sensor of 3296 × 2472 pixels, or the instrument and pose of a measurement
/// file and the model of a model file in its place. @throws Error
ChartSettings chart_settings(const std::optional<std::string>& measurement, const std::optional<std::string>& model);

/// The same detector with as many pixels of the same total size: a chart's smaller and larger frames.
Instrument resized(const Instrument& instrument, int columns, int rows);

/// The instrument in the words of the simulator, whose long double derivation is the charts' reference.
synth::Bench bench_of(const Instrument& instrument);
/// And back, by way of the instrument file that the simulator would write; its sensor is any.
Instrument instrument_of(const synth::Bench& bench);

}  // namespace scatmap::tools
