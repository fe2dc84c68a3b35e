#include "calib/export_poni.h"

#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/output_file.h"
#include "scatmap/base/rotation.h"

namespace scatmap::calib {
namespace {

// Sample axes to pyFAI's. Each is its own inverse.
Eigen::Matrix3d pyfai_from_sample(PoniAxes axes) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  if (axes == PoniAxes::kYxz) m << 0, 1, 0, 1, 0, 0, 0, 0, 1;
  return m;
}

struct Entry {
  std::string value;
  int line;
};

using Entries = std::map<std::string, Entry>;

Entries entries_of(const std::string& text, const std::string& name) {
  Entries out;
  std::istringstream lines(text);
  std::string line;
  const auto trimmed = [](const std::string& s) {
    const auto first = s.find_first_not_of(" \t\r");
    return first == std::string::npos ? std::string() : s.substr(first, s.find_last_not_of(" \t\r") - first + 1);
  };
  for (int number = 1; std::getline(lines, line); ++number) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    const auto colon = line.find(':');
    const std::string where = name + ":" + std::to_string(number);
    if (colon == std::string::npos) throw Error({where, "has no colon", "'" + line + "'", "key: value"});
    // pyFAI appends a new geometry to an old file and reads the last; here that would be a guess.
    if (!out.emplace(trimmed(line.substr(0, colon)), Entry{trimmed(line.substr(colon + 1)), number}).second) {
      throw Error(
          {where, "states " + trimmed(line.substr(0, colon)) + " again: the file holds several geometries", {}, "one"});
    }
  }
  return out;
}

double number(const Entries& entries, const std::string& name, const std::string& key) {
  const auto found = entries.find(key);
  if (found == entries.end()) throw Error({name, "lacks " + key, {}, {}});
  const std::string& text = found->second.value;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && std::isfinite(value)) return value;
  throw Error({name + ":" + std::to_string(found->second.line) + ": " + key, "is not a number", "'" + text + "'", {}});
}

void read_detector(const Entries& entries, const std::string& name, Poni& poni) {
  if (entries.contains("PixelSize1")) {
    poni.row_pitch_m = number(entries, name, "PixelSize1");
    poni.column_pitch_m = number(entries, name, "PixelSize2");
    return;
  }
  const auto found = entries.find("Detector_config");
  if (found == entries.end()) throw Error({name, "lacks Detector_config, which states the pixel size", {}, {}});
  const std::string where = name + ":" + std::to_string(found->second.line) + ": Detector_config";
  const auto config = nlohmann::json::parse(found->second.value, nullptr, false);
  if (!config.is_object() || !config.contains("pixel1") || !config.contains("pixel2") ||
      !config["pixel1"].is_number() || !config["pixel2"].is_number()) {
    throw Error(
        {where, "does not state pixel1 and pixel2", found->second.value, "the configuration of a plain Detector"});
  }
  if (config.contains("orientation") && config["orientation"] != 3) {
    throw Error({where, "has an orientation whose meaning differs between versions of pyFAI", {}, "3"});
  }
  poni.row_pitch_m = config["pixel1"].get<double>();
  poni.column_pitch_m = config["pixel2"].get<double>();
  if (!config.contains("max_shape") || config["max_shape"].is_null()) return;
  const auto& shape = config["max_shape"];
  const auto is_side = [](const nlohmann::json& v) {
    constexpr double kLongest = 1 << 20;
    return v.is_number_integer() && v.get<double>() >= 1 && v.get<double>() <= kLongest;
  };
  if (!shape.is_array() || shape.size() != 2 || !is_side(shape[0]) || !is_side(shape[1])) {
    throw Error({where, "has a max_shape that is not two sides of an image", {}, "[rows, columns]"});
  }
  poni.rows = shape[0].get<int>();
  poni.columns = shape[1].get<int>();
}

}  // namespace

Eigen::Matrix3d Poni::rotation() const { return rotation_z(rot3_rad) * rotation_y(-rot2_rad) * rotation_x(-rot1_rad); }

Eigen::Vector3d Poni::pixel_m(double column, double row) const {
  return rotation() *
         Eigen::Vector3d((row + 0.5) * row_pitch_m - poni1_m, (column + 0.5) * column_pitch_m - poni2_m, distance_m);
}

PoniExport poni_at_spot(const SampleView& view, int columns, int rows) {
  const bool mirrored = view.column_step.cross(view.row_step).dot(view.detector_normal) < 0;
  PoniExport out{{}, mirrored ? PoniAxes::kXyz : PoniAxes::kYxz};
  const Eigen::Matrix3d turn = pyfai_from_sample(out.axes);
  Eigen::Matrix3d r;
  r << (turn * view.row_step).normalized(), (turn * view.column_step).normalized(), turn * view.detector_normal;
  Poni& p = out.poni;
  p.columns = columns;
  p.rows = rows;
  p.row_pitch_m = view.row_step.norm();
  p.column_pitch_m = view.column_step.norm();
  // pyFAI counts from the first pixel's corner.
  const Eigen::Vector3d corner =
      r.transpose() * (turn * view.origin) - Eigen::Vector3d(0.5 * p.row_pitch_m, 0.5 * p.column_pitch_m, 0);
  p.poni1_m = -corner.x();
  p.poni2_m = -corner.y();
  p.distance_m = corner.z();
  p.rot1_rad = std::atan2(-r(2, 1), r(2, 2));
  p.rot2_rad = std::atan2(r(2, 0), std::hypot(r(2, 1), r(2, 2)));
  p.rot3_rad = std::atan2(r(1, 0), r(0, 0));
  return out;
}

SampleView view_from_poni(const PoniExport& poni, const Vector3<double>& to_source) {
  const Eigen::Matrix3d turn = pyfai_from_sample(poni.axes);
  const Poni& p = poni.poni;
  const Eigen::Matrix3d r = turn * p.rotation();
  return {turn * p.pixel_m(0, 0),          r.col(1) * p.column_pitch_m, r.col(0) * p.row_pitch_m, r.col(2), to_source,
          p.row_pitch_m * p.column_pitch_m};
}

std::string to_poni(const PoniExport& poni, const std::string& comment) {
  const Poni& p = poni.poni;
  std::string text, line;
  for (std::istringstream lines(comment); std::getline(lines, line);) text += "# " + line + "\n";
  text += std::string("# Seen from the illuminated spot about the sample normal: 2theta is theta_s; chi is ") +
          (poni.axes == PoniAxes::kYxz ? "phi_s - 180 deg" : "270 deg - phi_s") + ", phi_s measured from -x\n";
  text += "poni_version: 2\nDetector: Detector\n";
  text += "Detector_config: {\"pixel1\": " + number_text(p.row_pitch_m) +
          ", \"pixel2\": " + number_text(p.column_pitch_m) + ", \"max_shape\": [" + std::to_string(p.rows) + ", " +
          std::to_string(p.columns) + "]}\n";
  text += "Distance: " + number_text(p.distance_m) + "\nPoni1: " + number_text(p.poni1_m) +
          "\nPoni2: " + number_text(p.poni2_m) + "\n";
  return text + "Rot1: " + number_text(p.rot1_rad) + "\nRot2: " + number_text(p.rot2_rad) +
         "\nRot3: " + number_text(p.rot3_rad) + "\n";
}

Poni parse_poni(const std::string& text, const std::string& name) {
  const Entries entries = entries_of(text, name);
  if (entries.empty()) throw Error({name, "is empty", {}, {}});
  if (entries.contains("poni_version") && number(entries, name, "poni_version") > 2) {
    throw Error({name, "has a poni_version that is not known", entries.at("poni_version").value, "1 or 2"});
  }
  Poni out;
  read_detector(entries, name, out);
  out.distance_m = number(entries, name, "Distance");
  out.poni1_m = number(entries, name, "Poni1");
  out.poni2_m = number(entries, name, "Poni2");
  out.rot1_rad = number(entries, name, "Rot1");
  out.rot2_rad = number(entries, name, "Rot2");
  out.rot3_rad = number(entries, name, "Rot3");
  if (!(out.row_pitch_m > 0 && out.column_pitch_m > 0 && out.distance_m > 0))
    throw Error({name, "has a pixel size or distance that is not positive", {}, {}});
  return out;
}

Poni read_poni(const std::filesystem::path& path) { return parse_poni(read_text_file(path), path.string()); }

}  // namespace scatmap::calib
