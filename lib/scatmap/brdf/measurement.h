#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scatmap/angles/instrument.h"
#include "scatmap/base/provenance.h"
#include "scatmap/brdf/scale.h"

namespace scatmap {

/// A dark level stated instead of measured.
struct StatedDark {
  double level_dn = 0;
  double u_level_dn = 0;
};

/// Frames taken one after the other with one exposure time and one stack of filters.
struct Exposure {
  std::string where;  ///< "measurement.toml:12: exposure.0", for messages
  std::vector<std::filesystem::path> frames;
  std::vector<std::filesystem::path> darks;  ///< empty when stated_dark is given
  std::optional<StatedDark> stated_dark;
  double exposure_s = 0;
  double u_exposure = 0;  ///< relative standard uncertainty of the exposure time, common to the exposure's frames
  std::vector<std::string> filters;  ///< names, none twice
  std::optional<double> arm_rad;     ///< where the file states it for these frames
};

/// Where to sum the beam in the signature frames; found from the frames when absent.
struct SignatureAperture {
  std::optional<double> radius_px;
};

/// A measurement file (measurement.toml): one pose, its exposures, the beam signature, the filters.
struct Measurement {
  std::filesystem::path file;
  std::filesystem::path instrument_file;
  Instrument instrument;
  double wavelength_m = 0;
  Pose pose;
  std::map<std::string, Filter> filters;
  std::vector<Exposure> signatures{1};  ///< exposures of the straight-through beam, one or more
  SignatureAperture aperture;
  std::vector<Exposure> exposures;  ///< one or more
  double laser_drift = 0;  ///< relative half width between signature and sample frames, common to all exposures
  double laser_drift_between_exposures = 0;  ///< relative half width of each exposure on its own
  std::optional<std::filesystem::path> flat;
  std::optional<std::filesystem::path> bad_pixels;
};

/// Reads and checks a measurement file and its instrument file; frames are not read yet. Paths in it are relative to
/// it.
/// @throws Error naming file, line and key
Measurement read_measurement(const std::filesystem::path& path);

/// log10 of 1/transmittance of a stack: the sum of its filters' OD.
double stack_od(const Measurement& m, const Exposure& e);

/// What the signature rests on.
struct SignatureUse {
  double u = 0;                    ///< relative standard uncertainty of the beam's sum: its own noise
  std::vector<double> share = {};  ///< of each signature exposure in that sum, adding to 1; empty: all on the first
};

/// Causes of the scale of one sample exposure's map by identity: a filter in its stack and in all signature stacks
/// cancels exactly, one that is in some of the latter counts by their share.
ScaleBudget exposure_scale(const Measurement& m, const Exposure& e, const SignatureUse& signature);

/// Causes of what one signature exposure says of the unfiltered beam: its filters and its time; with several, the
/// laser's power during each.
ScaleBudget signature_scale(const Measurement& m, std::size_t exposure);

}  // namespace scatmap
