#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scatmap/angles/geometry.h"
#include "scatmap/base/toml_file.h"

namespace scatmap {

/// What turns electrons into counts. Absent numbers stay absent: nothing is guessed.
struct Sensor {
  std::optional<double> gain_e_per_dn;
  std::optional<double> read_noise_e;
  std::optional<double> saturation_dn;  ///< raw counts at which a pixel is saturated
  double nonlinearity_percent = 0;      ///< largest relative deviation at saturation, after any correction
  double bias_dn = 0;                   ///< zero point of the linearity polynomial
  /// corrected = bias + x (1 + c0 x + c1 x² + …), x = raw − bias in DN. Empty: none.
  std::vector<double> linearity;
  /// EGAIN of the frames that the gain was measured from: what frames of this camera say of themselves.
  std::optional<double> header_gain_e_per_dn{};
};

/// A parameter that a calibration kept at its nominal value.
struct LeftOutParameter {
  std::string name;  ///< of a geometry parameter, or of a mirror mount's ("mount.NAME.tilt_deg")
  std::string reason;
  std::optional<double> bound_px;  ///< by how much that may shift a direction, if known
};

/// Standard covariance of some geometry parameters, in their file units (mm, µm, deg).
struct Calibration {
  std::vector<std::string> parameters;       ///< names out of geometry_keys()
  Eigen::MatrixXd covariance;                ///< parameters × parameters, symmetric, positive semi-definite
  std::vector<LeftOutParameter> left_out{};  ///< [[calibration.left_out]]
};

/// An instrument file (instrument.toml): detector, arm, stage, beam, sample, sensor, and its calibration if it has one.
struct Instrument {
  int columns = 0;
  int rows = 0;
  bool flip_columns = false;
  bool flip_rows = false;
  /// detector.lens_cameramodel, absolute: rays come from this mrcal model and replace the flat detector's (lens.h).
  /// Absent: a bare CCD.
  std::optional<std::filesystem::path> lens_cameramodel{};
  Geometry<double> geometry;
  double arm_encoder_sigma_rad = 0;
  double stage_encoder_sigma_rad = 0;
  Sensor sensor;
  std::optional<Calibration> calibration;
};

/// Where the motors stand, rad, as commanded.
struct Pose {
  double stage_rad = 0;
  double arm_rad = 0;
};

/// Reads and checks an instrument file. Missing continuous keys are zero; detector.columns, rows, pitch_um and
/// distance_mm are required. A relative detector.lens_cameramodel is beside the instrument file, and must exist.
/// @throws Error naming file, line and key
Instrument read_instrument(const std::filesystem::path& path);
/// The same from text; `name` stands for the file in messages.
Instrument parse_instrument(const std::string& text, const std::string& name);
/// The file's text; reading it gives the same doubles, bit for bit.
std::string to_toml(const Instrument& instrument);

}  // namespace scatmap
