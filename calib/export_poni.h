#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "scatmap/angles/pixel_plane.h"

namespace scatmap::calib {

/// pyFAI's geometry of a flat detector (.poni, orientation 3): pixel (row i, column j) lies at
///   t = R·((i + 1/2)·row_pitch − poni1, (j + 1/2)·column_pitch − poni2, distance),
///   R = Rz(rot3)·Ry(−rot2)·Rx(−rot1)
/// about pyFAI's axes 1 (slow), 2 (fast), 3; 2theta = atan2(hypot(t1, t2), t3), chi = atan2(t1, t2).
struct Poni {
  int columns = 0;
  int rows = 0;
  double row_pitch_m = 0;     ///< pixel1
  double column_pitch_m = 0;  ///< pixel2
  double distance_m = 0;
  double poni1_m = 0;
  double poni2_m = 0;
  double rot1_rad = 0;
  double rot2_rad = 0;
  double rot3_rad = 0;

  Eigen::Matrix3d rotation() const;
  /// t of a pixel position in our convention: integers are pixel centres.
  Eigen::Vector3d pixel_m(double column, double row) const;
};

/// How pyFAI's axes lie in sample axes (x forward, y, z normal): always 2theta = theta_s. The image must not be
/// mirrored for pyFAI, so the other two axes follow the detector's handedness.
enum class PoniAxes {
  kYxz,  ///< t = (y, x, z): chi = phi_s − pi
  kXyz,  ///< t = (x, y, z), for a detector with one flip: chi = 3 pi/2 − phi_s
};

struct PoniExport {
  Poni poni;
  PoniAxes axes;
};

/// The detector of a pose, seen from the spot. Exact.
PoniExport poni_at_spot(const SampleView& view, int columns, int rows);
/// Back: origin, steps, normal and pixel area of the view; `to_source` is not in a .poni and is left as given.
SampleView view_from_poni(const PoniExport& poni, const Vector3<double>& to_source);

/// The text of a .poni file, version 2, numbers exact; says in a comment what chi means.
std::string to_poni(const PoniExport& poni, const std::string& comment);
/// Reads a .poni file of version 1 or 2 whose detector states its pixel size (Detector_config, or PixelSize1 and 2).
/// @throws Error with file and line: missing or doubled keys, bad numbers, a named detector without pixel size, an
/// orientation other than 3
Poni read_poni(const std::filesystem::path& path);
Poni parse_poni(const std::string& text, const std::string& name);

}  // namespace scatmap::calib
