#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data-synthetic/render.h"
#include "data-synthetic/truth_geometry.h"
#include "data-synthetic/truth_model.h"

namespace scatmap::synth {

struct NdFilter {
  std::string name;
  double od = 0;              ///< what the lab believes
  double true_od = 0;         ///< what the filter does
  std::string tolerance_key;  ///< "tolerance_percent", "tolerance_od" or "u_od"
  double tolerance = 0;
};

/// Frames of one exposure time behind one stack of filters, and their darks.
struct FrameStack {
  double exposure_s = 0;       ///< what the lab believes
  double true_exposure_s = 0;  ///< what the shutter does, darks included
  int frames = 1;
  int darks = 0;
  std::vector<std::string> filters;
  std::optional<double> u_exposure_percent;  ///< the lab's own statement; passed on
};

struct LaserTruth {
  double electrons_per_s = 0;  ///< of the whole beam straight onto the sensor, no filter, at the signature's time
  double drift_percent = 0;    ///< true change of the power from the signature to the sample's frames
  double drift_tolerance_percent = 0;  ///< what the lab believes its standard drift to be
};

/// A measurement of a sample: signature and exposures.
struct BrdfScene {
  double stage_deg = 0;
  double arm_deg = 0;
  double signature_arm_deg = 180;
  LaserTruth laser;
  std::vector<NdFilter> filters;
  std::vector<FrameStack> signatures;  ///< exposures of the beam, one or more
  std::vector<FrameStack> exposures;
  ModelTruth model;
};

struct MirrorMount {
  std::string name;
  double tilt_deg = 0;
  double height_mm = 0;
};

/// One calibration target as commanded.
struct MirrorTarget {
  bool direct = false;
  std::size_t mount = 0;
  double stage_deg = 0;
  double arm_deg = 0;
  double tilt_deg = 0;
};

/// A calibration run with a flat mirror and with the direct beam.
struct MirrorScene {
  double sigma_px = 0;  ///< of the centroids in targets.csv, each axis
  bool write_frames = false;
  double spot_e = 0;  ///< electrons in a spot's frame
  double exposure_s = 1;
  std::vector<MirrorMount> mounts;
  std::vector<MirrorTarget> targets;
};

/// Frames under steady, nearly uniform light, at several exposure times: what photon transfer wants.
struct FlatScene {
  std::vector<double> exposure_s;
  int frames = 2;  ///< per exposure time
  int darks = 2;
  double electrons_per_s = 0;  ///< of the brightest pixel
  double falloff_percent = 0;  ///< less light in the corners, growing with the square of the distance
  double prnu_percent = 0;     ///< standard deviation of the pixels' gains
};

/// A scene file, read strictly. Exactly one of `brdf`, `mirror` and `flats` is present.
struct Scene {
  std::string name;  ///< of the file, for messages
  std::uint64_t seed = 0;
  double wavelength_nm = 0;
  std::string date_obs;
  Bench bench;          ///< true
  Bench nominal_bench;  ///< what the lab believes
  SensorTruth sensor;
  SensorTruth nominal_sensor;
  double signature_diameter_mm = 1;  ///< of the beam on the sensor, 1/e²
  std::optional<BrdfScene> brdf;
  std::optional<MirrorScene> mirror;
  std::optional<FlatScene> flats;
};

/// @throws Error naming file, line and key: missing, unknown, of the wrong type or out of range
Scene read_scene(const std::filesystem::path& path);
/// The same from text; `name` stands for the file in messages.
Scene parse_scene(const std::string& text, const std::string& name);

}  // namespace scatmap::synth
