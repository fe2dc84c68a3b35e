#include "scatmap/angles/instrument.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <set>
#include <utility>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/provenance.h"
#include "scatmap/base/units.h"

namespace scatmap {
namespace fs = std::filesystem;
namespace {

constexpr int kMaxSide = 32768;
constexpr NumberRange kAngleDeg{-360, 360, false};
constexpr NumberRange kTiltDeg{-89, 89, false};
constexpr NumberRange kLengthMm{-1e7, 1e7, false};

double get(const TomlTable& t, const std::string& key, const NumberRange& range, double unit) {
  return t.number_or(key, 0, range) * unit;
}

std::pair<double, double> get_pair(const TomlTable& t, const std::string& key, const NumberRange& range, double unit) {
  if (!t.has(key)) return {0, 0};
  const auto v = t.numbers(key, 2, range);
  return {v[0] * unit, v[1] * unit};
}

std::optional<fs::path> read_lens_path(const TomlTable& t) {
  constexpr const char* kKey = "lens_cameramodel";
  const auto stated = t.optional_string(kKey);
  if (!stated) return std::nullopt;
  const fs::path path = fs::absolute(t.resolve(*stated)).lexically_normal();
  if (!fs::is_regular_file(path))
    throw Error(
        {t.where(kKey), "does not exist or is no file", utf8_text(path.string()), "an mrcal .cameramodel file"});
  if (utf8_text(path.string()) != path.string())
    throw Error({t.where(kKey), "lies in a folder whose name is no UTF-8", utf8_text(path.string()), {}});
  return path;
}

void read_detector(const TomlTable& t, Instrument& out) {
  out.columns = t.integer("columns", 1, kMaxSide);
  out.rows = t.integer("rows", 1, kMaxSide);
  out.flip_columns = t.boolean_or("flip_columns", false);
  out.flip_rows = t.boolean_or("flip_rows", false);
  out.lens_cameramodel = read_lens_path(t);
  Geometry<double>& g = out.geometry;
  g.distance = t.number("distance_mm", {0, 1e7, true}) * kMetrePerMm;
  std::tie(g.offset_x, g.offset_y) = get_pair(t, "offset_mm", kLengthMm, kMetrePerMm);
  const auto pitch = t.numbers("pitch_um", 2, {0, 1e6, true});
  g.pixel_column = pitch[0] * kMetrePerUm;
  g.pixel_row = pitch[1] * kMetrePerUm;
  if (t.has("rotation_deg")) {
    const auto rotation = t.numbers("rotation_deg", 3, kAngleDeg);
    g.rotation_pitch = rotation[0] * kRadPerDeg;
    g.rotation_yaw = rotation[1] * kRadPerDeg;
    g.rotation_roll = rotation[2] * kRadPerDeg;
  }
}

void read_mechanics(const TomlTable& file, Instrument& out) {
  Geometry<double>& g = out.geometry;
  if (const auto arm = file.optional_table("arm")) {
    g.arm_zero = get(*arm, "zero_deg", kAngleDeg, kRadPerDeg);
    std::tie(g.arm_axis_x, g.arm_axis_z) = get_pair(*arm, "axis_offset_mm", kLengthMm, kMetrePerMm);
    std::tie(g.arm_axis_tilt_x, g.arm_axis_tilt_z) = get_pair(*arm, "axis_tilt_deg", kTiltDeg, kRadPerDeg);
    out.arm_encoder_sigma_rad = get(*arm, "encoder_sigma_deg", {0, 360, false}, kRadPerDeg);
  }
  if (const auto stage = file.optional_table("stage")) {
    g.stage_zero = get(*stage, "zero_deg", kAngleDeg, kRadPerDeg);
    out.stage_encoder_sigma_rad = get(*stage, "encoder_sigma_deg", {0, 360, false}, kRadPerDeg);
  }
  if (const auto beam = file.optional_table("beam")) {
    std::tie(g.beam_offset_x, g.beam_offset_y) = get_pair(*beam, "offset_mm", kLengthMm, kMetrePerMm);
    g.beam_elevation = get(*beam, "elevation_deg", kTiltDeg, kRadPerDeg);
  }
  if (const auto sample = file.optional_table("sample")) {
    g.sample_tilt = get(*sample, "tilt_deg", kTiltDeg, kRadPerDeg);
    g.sample_height = get(*sample, "height_mm", kLengthMm, kMetrePerMm);
  }
}

// A correction that turns over below saturation would give two counts one signal.
void require_rising(const Sensor& s, const TomlTable& t) {
  constexpr int kSteps = 1000;
  if (s.linearity.empty() || !s.saturation_dn) return;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = (*s.saturation_dn - s.bias_dn) * i / kSteps;
    double slope = 0;
    for (std::size_t k = s.linearity.size(); k > 0; --k)
      slope = (slope + static_cast<double>(k + 1) * s.linearity[k - 1]) * x;
    if (1 + slope > 0) continue;
    throw Error({t.where("linearity"), "turns over below saturation_dn", number_text(std::round(s.bias_dn + x)) + " DN",
                 "a corrected signal that grows with the counts"});
  }
}

Sensor read_sensor(const TomlTable& t) {
  Sensor s;
  s.gain_e_per_dn = t.optional_number("gain_e_per_dn", kPositive);
  s.header_gain_e_per_dn = t.optional_number("header_gain_e_per_dn", kPositive);
  s.read_noise_e = t.optional_number("read_noise_e", kNotNegative);
  s.saturation_dn = t.optional_number("saturation_dn", kPositive);
  s.nonlinearity_percent = t.number_or("nonlinearity_percent", 0, {0, 100, false});
  s.bias_dn = t.number_or("bias_dn", 0);
  if (s.saturation_dn && !(*s.saturation_dn > s.bias_dn)) {
    throw Error({t.where("saturation_dn"), "is not above bias_dn", {}, {}});
  }
  if (t.has("linearity")) s.linearity = t.numbers("linearity", 0);
  require_rising(s, t);
  return s;
}

const GeometryKey* find_key(const std::string& name) {
  for (const GeometryKey& key : geometry_keys()) {
    if (name == key.name) return &key;
  }
  return nullptr;
}

Calibration read_calibration(const TomlTable& t) {
  Calibration c;
  c.parameters = t.strings("parameters");
  std::set<std::string> seen;
  for (const std::string& name : c.parameters) {
    if (find_key(name) == nullptr) throw Error({t.where("parameters"), "names no geometric parameter", name, {}});
    if (!seen.insert(name).second) throw Error({t.where("parameters"), "names a parameter twice", name, {}});
  }
  const auto rows = t.matrix("covariance");
  const auto n = static_cast<Eigen::Index>(c.parameters.size());
  const std::string wanted = std::to_string(n) + " rows of " + std::to_string(n);
  if (rows.size() != c.parameters.size()) {
    throw Error({t.where("covariance"), "has the wrong size", std::to_string(rows.size()) + " rows", wanted});
  }
  c.covariance.resize(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    if (row.size() != rows.size())
      throw Error({t.where("covariance"), "has the wrong size", std::to_string(row.size()) + " columns", wanted});
    for (Eigen::Index j = 0; j < n; ++j) c.covariance(i, j) = row[static_cast<std::size_t>(j)];
  }
  for (const TomlTable& p : t.tables("left_out")) {
    c.left_out.push_back({p.string("name"), p.string("reason"), p.optional_number("bound_px", kNotNegative)});
  }
  return c;
}

// Scaled by the diagonal, so that units do not decide what counts as negative.
void check_covariance(const Calibration& c, const std::string& where) {
  if (c.parameters.empty()) return;  // every parameter left out
  const Eigen::VectorXd variance = c.covariance.diagonal();
  if (!(variance.array() >= 0).all()) throw Error({where, "has a negative variance", {}, {}});
  const Eigen::VectorXd scale = (variance.array() > 0).select(variance.array().rsqrt(), 0.0);
  const Eigen::MatrixXd correlation = scale.asDiagonal() * c.covariance * scale.asDiagonal();
  constexpr double kTolerance = 1e-9;
  if (!((correlation - correlation.transpose()).cwiseAbs().maxCoeff() <= kTolerance))
    throw Error({where, "is not symmetric", {}, {}});
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(correlation, Eigen::EigenvaluesOnly);
  if (!(solver.eigenvalues().minCoeff() >= -kTolerance)) throw Error({where, "is not positive semi-definite", {}, {}});
}

Instrument read_tables(const TomlTable& file) {
  Instrument out;
  read_detector(file.table("detector"), out);
  read_mechanics(file, out);
  if (const auto sensor = file.optional_table("sensor")) out.sensor = read_sensor(*sensor);
  if (const auto calibration = file.optional_table("calibration")) {
    out.calibration = read_calibration(*calibration);
    check_covariance(*out.calibration, calibration->where("covariance"));
  }
  file.reject_unknown_keys();
  return out;
}

}  // namespace

Instrument read_instrument(const std::filesystem::path& path) { return read_tables(TomlTable::read(path)); }

Instrument parse_instrument(const std::string& text, const std::string& name) {
  return read_tables(TomlTable::parse(text, name));
}

}  // namespace scatmap
