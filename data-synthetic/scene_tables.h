#pragma once
#include <optional>
#include <string>

#include "data-synthetic/scene.h"
#include "scatmap/base/toml_file.h"

namespace scatmap::synth {

/// An optional sub-table; an empty one when it is absent.
TomlTable table_or_empty(const TomlTable& table, const std::string& key);

/// The tables [detector] [arm] [stage] [beam] [sample] of `root`. Keys that are absent keep the value of `start`.
Bench read_bench(const TomlTable& root, const Bench& start);
/// The table [sensor] of `root`, likewise.
SensorTruth read_sensor(const TomlTable& root, const SensorTruth& start);

/// The sample's measurement: everything that a scene of kind "brdf" has beyond the bench.
BrdfScene read_brdf_scene(const TomlTable& root, const Bench& bench, double wavelength_nm);
/// The calibration run: everything that a scene of kind "mirror" has beyond the bench.
MirrorScene read_mirror_scene(const TomlTable& root, const Bench& bench);
/// The photon transfer's light: the table [flats] of a scene of kind "flats".
FlatScene read_flat_scene(const TomlTable& root);

}  // namespace scatmap::synth
