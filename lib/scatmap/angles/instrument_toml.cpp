#include <cstdio>
#include <string>

#include "scatmap/angles/instrument.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/units.h"

namespace scatmap {
namespace {

std::string list(std::initializer_list<double> inside, double unit) {
  std::string text;
  for (const double v : inside) text += (text.empty() ? "[" : ", ") + number_text_in_unit(v, unit);
  return text + "]";
}

// A TOML basic string: quotes, backslashes and control characters as codes.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) >= ' ' && c != 0x7f && c != '"' && c != '\\') {
      out += c;
      continue;
    }
    constexpr const char* kDigits = "0123456789abcdef";
    out += "\\u00";
    out += kDigits[c >> 4];
    out += kDigits[c & 15];
  }
  return out + "\"";
}

std::string line(const std::string& key, const std::string& value) { return key + " = " + value + "\n"; }

std::string detector_text(const Instrument& in) {
  const Geometry<double>& g = in.geometry;
  std::string t = "[detector]\n" + line("columns", std::to_string(in.columns)) + line("rows", std::to_string(in.rows));
  t += line("pitch_um", list({g.pixel_column, g.pixel_row}, kMetrePerUm));
  t += line("distance_mm", number_text_in_unit(g.distance, kMetrePerMm));
  t += line("offset_mm", list({g.offset_x, g.offset_y}, kMetrePerMm));
  t += line("rotation_deg", list({g.rotation_pitch, g.rotation_yaw, g.rotation_roll}, kRadPerDeg));
  t += line("flip_columns", in.flip_columns ? "true" : "false");
  t += line("flip_rows", in.flip_rows ? "true" : "false");
  return in.lens_cameramodel ? t + line("lens_cameramodel", quoted(in.lens_cameramodel->string())) : t;
}

std::string mechanics_text(const Instrument& in) {
  const Geometry<double>& g = in.geometry;
  std::string t = "\n[arm]\n" + line("zero_deg", number_text_in_unit(g.arm_zero, kRadPerDeg));
  t += line("axis_offset_mm", list({g.arm_axis_x, g.arm_axis_z}, kMetrePerMm));
  t += line("axis_tilt_deg", list({g.arm_axis_tilt_x, g.arm_axis_tilt_z}, kRadPerDeg));
  t += line("encoder_sigma_deg", number_text_in_unit(in.arm_encoder_sigma_rad, kRadPerDeg));
  t += "\n[stage]\n" + line("zero_deg", number_text_in_unit(g.stage_zero, kRadPerDeg));
  t += line("encoder_sigma_deg", number_text_in_unit(in.stage_encoder_sigma_rad, kRadPerDeg));
  t += "\n[beam]\n" + line("offset_mm", list({g.beam_offset_x, g.beam_offset_y}, kMetrePerMm));
  t += line("elevation_deg", number_text_in_unit(g.beam_elevation, kRadPerDeg));
  t += "\n[sample]\n" + line("tilt_deg", number_text_in_unit(g.sample_tilt, kRadPerDeg));
  return t + line("height_mm", number_text_in_unit(g.sample_height, kMetrePerMm));
}

std::string sensor_text(const Sensor& s) {
  std::string t = "\n[sensor]\n";
  if (s.gain_e_per_dn) t += line("gain_e_per_dn", number_text(*s.gain_e_per_dn));
  if (s.header_gain_e_per_dn) t += line("header_gain_e_per_dn", number_text(*s.header_gain_e_per_dn));
  if (s.read_noise_e) t += line("read_noise_e", number_text(*s.read_noise_e));
  if (s.saturation_dn) t += line("saturation_dn", number_text(*s.saturation_dn));
  t += line("nonlinearity_percent", number_text(s.nonlinearity_percent)) + line("bias_dn", number_text(s.bias_dn));
  if (s.linearity.empty()) return t;
  std::string coefficients;
  for (const double c : s.linearity) coefficients += (coefficients.empty() ? "[" : ", ") + number_text(c);
  return t + line("linearity", coefficients + "]");
}

std::string calibration_text(const Calibration& c) {
  std::string t = "\n[calibration]\nparameters = [";
  for (std::size_t i = 0; i < c.parameters.size(); ++i) t += (i == 0 ? "" : ", ") + quoted(c.parameters[i]);
  t += "]\ncovariance = [\n";
  for (Eigen::Index i = 0; i < c.covariance.rows(); ++i) {
    for (Eigen::Index j = 0; j < c.covariance.cols(); ++j)
      t += (j == 0 ? "  [" : ", ") + number_text(c.covariance(i, j));
    t += "],\n";
  }
  t += "]\n";
  for (const LeftOutParameter& p : c.left_out) {
    t += "\n[[calibration.left_out]]\nname = " + quoted(p.name) + "\nreason = " + quoted(p.reason) + "\n";
    if (p.bound_px) t += line("bound_px", number_text(*p.bound_px));
  }
  return t;
}

}  // namespace

std::string to_toml(const Instrument& in) {
  std::string text = detector_text(in) + mechanics_text(in) + sensor_text(in.sensor);
  if (in.calibration) text += calibration_text(*in.calibration);
  return text;
}

}  // namespace scatmap
