#pragma once
#include <filesystem>
#include <string>

#include "data-synthetic/scene.h"
#include "scatmap/base/provenance.h"

namespace scatmap::synth {

/// Fills the existing, empty folder with what the lab has (frames/, instrument.toml, measurement.toml and model.toml,
/// or targets.csv) and with truth/ (brdf.fits or targets.csv, instrument.toml, pose.toml, scene.toml).
/// @param scene_text copied to truth/scene.toml
/// @throws Error if a beam misses the sensor, or a file cannot be written
void write_dataset(const Scene& scene, const std::string& scene_text, const std::filesystem::path& folder,
                   const Provenance& provenance);

/// The part that belongs to a scene of one kind; `folder` has frames/ and truth/.
void write_brdf_dataset(const Scene& scene, const std::filesystem::path& folder, const Provenance& provenance);
void write_mirror_dataset(const Scene& scene, const std::filesystem::path& folder, const Provenance& provenance);
void write_flat_dataset(const Scene& scene, const std::filesystem::path& folder, const Provenance& provenance);

/// True where the point lies on the sensor.
bool on_sensor(const Bench& bench, const PixelPoint& point);

}  // namespace scatmap::synth
