#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scatmap/brdf/brdf_map.h"
#include "scatmap/brdf/measurement.h"
#include "scatmap/counts/reduce.h"

namespace scatmap {

/// Reads and reduces the exposures of a measurement, each once; each list of darks is read and combined once, and kept
/// until no exposure to come needs it.
class FrameSource {
 public:
  /// Reads flat and bad pixels. @throws Error, also when the instrument lacks sensor.gain_e_per_dn, read_noise_e or
  /// saturation_dn
  explicit FrameSource(const Measurement& measurement);

  struct Reduced {
    Counts counts;
    int dark_group;
    double pooled_dark_noise_dn;  ///< of a single frame; 0 when not measured from darks
    ExposureRecord record;
  };
  Reduced reduce_exposure(const Exposure& exposure, const std::string& role);

  struct Dark {
    MasterDark master;
    std::vector<InputRecord> records;
    int group;
  };
  /// An exposure as read, for the fused pass.
  struct Raw {
    std::vector<Frame> frames;
    std::shared_ptr<const Dark> dark;
    double pooled_dark_noise_dn;  ///< as above
    ExposureRecord record;
    bool moved;  ///< the scene changed between the frames by more than noise and drift
  };
  Raw read_exposure(const Exposure& exposure, const std::string& role);

  /// What is odd about the frames read so far, in words.
  const std::vector<std::string>& notes() const { return notes_; }
  const SensorModel& sensor() const { return sensor_; }
  const PixelResponse& response() const { return response_; }

 private:
  void check(const Frame& frame, bool is_dark, double exposure_s);
  std::vector<Frame> read_all(const Exposure& exposure, bool are_darks, std::vector<InputRecord>& records);
  std::shared_ptr<const Dark> dark_of(const Exposure& exposure, double quantum_dn);
  void require_new(const InputRecord& record, const std::filesystem::path& path);
  void note_flat(const Frame& flat);
  void check_level(const MasterDark& dark, const std::string& role);
  struct Changes {
    bool bright;  ///< enough pixels show much light
    bool moved;   ///< and they changed between the frames
  };
  void note_light(const std::vector<Frame>& frames, const MasterDark& dark, const std::string& role, bool bright);
  Changes note_changes(const std::vector<Frame>& frames, const MasterDark& dark, const std::string& role);

  const Measurement& measurement_;
  SensorModel sensor_;
  PixelResponse response_;
  std::map<std::vector<std::filesystem::path>, std::shared_ptr<const Dark>> darks_;
  std::map<std::vector<std::filesystem::path>, int> darks_to_come_;  // exposures that are not read yet
  std::string row_order_, row_order_file_;
  std::map<std::string, std::filesystem::path> seen_;  // by checksum
  std::vector<std::string> notes_;
  std::optional<double> raw_flat_dn_;  // mean of a flat in whole DN
  int groups_ = 0;
};

}  // namespace scatmap
