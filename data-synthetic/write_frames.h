#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "data-synthetic/fits_writer.h"
#include "data-synthetic/scene.h"
#include "data-synthetic/write_toml.h"
#include "scatmap/base/provenance.h"

namespace scatmap::synth {

/// What all raw frames of one setting have in common.
struct FrameSetting {
  double exposure_s = 0;       ///< as the header says
  double true_exposure_s = 0;  ///< as the dark current sees it
  double stage_deg = 0;        ///< as commanded
  double arm_deg = 0;
  std::optional<double> tilt_deg{};  ///< known tilt of a mirror setting; 0 for a direct beam
  std::string target{};              ///< "specular" or "direct"; empty: the card is not written
};

/// Writes raw frames into DIR/frames and numbers them, so that each has its own random numbers.
class FrameWriter {
 public:
  FrameWriter(const Scene& scene, std::filesystem::path folder, const Provenance& provenance);

  /// Renders and writes one frame. @returns its path relative to the dataset. @throws Error
  std::string write(const std::string& name, const std::string& image_type, const Grid<double>& signal_e,
                    const FrameSetting& setting);
  /// Frames and darks of one stack: NAME_001.fits …, NAME_dark_001.fits … @throws Error
  /// @param image_type IMAGETYP of the frames under light
  StackFiles write_stack(const std::string& name, const Grid<double>& signal_e, const FrameStack& stack,
                         double stage_deg, double arm_deg, const std::string& image_type = "Light Frame");

 private:
  const Scene& scene_;
  std::filesystem::path folder_;
  const Provenance& provenance_;
  Grid<double> no_light_e_;
  std::uint64_t number_ = 0;
};

/// "HISTORY" cards: program, command line, inputs; printable ASCII.
std::vector<FitsCard> history_cards(const Provenance& provenance);

}  // namespace scatmap::synth
