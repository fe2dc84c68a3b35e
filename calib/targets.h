#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace scatmap::calib {

enum class TargetKind {
  kSpecular,  ///< the beam reflected by a flat mirror in the sample's place
  kDirect,    ///< no sample: the beam straight onto the detector
};

/// One spot of known origin: a line of targets.csv.
struct Target {
  TargetKind kind = TargetKind::kSpecular;
  double stage_rad = 0;  ///< commanded
  double arm_rad = 0;    ///< commanded
  double tilt_rad = 0;   ///< known extra out-of-plane tilt of this mirror setting; adds to the mount's
  double column_px = 0;  ///< centroid
  double row_px = 0;
  double sigma_px = 0;    ///< standard uncertainty of the centroid, each axis
  std::size_t mount = 0;  ///< index into TargetList::mounts; meaningless for kDirect
  std::string file;       ///< the frame it came from, if stated
  int line = 0;           ///< in the file, from 1
};

/// Whether a mount may be called so: letters, digits, '-', '_', '.' and spaces.
bool is_mount_name(const std::string& name);

struct TargetList {
  std::string name;                 ///< of the file, for messages
  std::vector<std::string> mounts;  ///< mirror mountings in order of appearance; "" where the file names none
  std::vector<Target> targets;
};

/// Reads targets.csv: a header line with the columns kind, stage_deg, arm_deg, tilt_deg, column_px, row_px, sigma_px
/// and optionally mount, file, in any order; then one target a line. Blank lines and lines starting with # are skipped.
/// @throws Error naming file and line: missing, unknown or doubled columns, wrong number of fields, bad numbers, no
/// target
TargetList read_targets(const std::filesystem::path& path);
/// The same from text; `name` stands for the file in messages.
TargetList parse_targets(const std::string& text, const std::string& name);
/// The file's text; reading it gives the same doubles.
std::string to_csv(const TargetList& list);

/// "targets.csv:12" or "targets.csv:12 (frame.fits)".
std::string label(const TargetList& list, const Target& target);

}  // namespace scatmap::calib
