#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/targets.h"
#include "scatmap/frame/frame.h"

namespace scatmap::calib {

/// How a spot came about: what a target needs besides its centroid. Absent: not stated.
struct SpotSetting {
  std::optional<TargetKind> kind;
  std::optional<double> stage_deg;
  std::optional<double> arm_deg;
  std::optional<double> tilt_deg;
  std::optional<std::string> mount;
};

/// The settings of frames, stated beside them (angles.csv).
class SettingTable {
 public:
  /// Reads a CSV with a header line: the column file, and any of kind, stage_deg, arm_deg, tilt_deg, mount. An empty
  /// field states nothing. column_px, row_px and sigma_px are passed over, so that a targets.csv can be measured again.
  /// Paths are relative to the CSV. Blank lines and lines starting with # are skipped. @throws Error with file and line
  static SettingTable read(const std::filesystem::path& path);

  /// The line of a frame: the same file, or else the only line with its file name. nullopt: none.
  /// @throws Error if several lines could be meant
  std::optional<SpotSetting> find(const std::filesystem::path& frame) const;
  /// @throws Error if a line would tell, by its file name alone, of two of these frames
  void require_one_frame_each(const std::vector<std::string>& frames) const;
  const std::string& name() const { return name_; }

 private:
  struct Line {
    std::filesystem::path file;
    SpotSetting setting;
  };
  const Line* line_of(const std::filesystem::path& frame) const;

  std::string name_;
  std::vector<Line> lines_;
};

/// `first` where it states something, else `second`.
SpotSetting combined(const SpotSetting& first, const SpotSetting& second);

/// What a frame's own header states: STAGEDEG, ARMDEG, TILTDEG and TARGET. A TARGET other than specular or direct, in
/// upper or lower case, says nothing here: other programs keep names of samples there.
SpotSetting header_setting(const Frame& frame);

/// A mirror at the stage angle sends the beam to arm = 2 stage; further off than this it misses any detector.
inline constexpr double kMirrorReach_deg = 20;

/// Where no kind is stated, no mirror can have made the spot and the arm is near the direct beam: what is wrong and how
/// to say better, for a note. @returns nullopt if there is no such doubt
std::optional<std::string> doubt_of_kind(const SpotSetting& setting);

/// A target of the setting, without its centroid: specular with tilt 0 unless stated; mount is left to the caller.
/// @throws Error naming the frame if a motor angle is not stated, or a direct beam has a tilt or mount
Target target_of(const SpotSetting& setting, const std::filesystem::path& frame);

/// "specular" or "direct". @throws Error naming `where`
TargetKind parse_kind(const std::string& text, const std::string& where);

}  // namespace scatmap::calib
