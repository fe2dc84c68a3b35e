#include "tools/chart/scene.h"

#include "data-synthetic/write_toml.h"
#include "scatmap/base/units.h"
#include "scatmap/brdf/measurement.h"
#include "scatmap/model/model_toml.h"

namespace scatmap::tools {
namespace {

constexpr const char* kPaperInstrument = R"([detector]
columns = 3296
rows = 2472
pitch_um = [5.5, 5.5]
distance_mm = 325.0
)";

constexpr const char* kPaperModel = R"(wavelength_nm = 632.8
[[term]]
kind = "microfacet"
rho = 0.7
m = 2e-4
n = [1.4, 0.0]
dtheta_deg = 0.5
dphi_deg = 45.0
[[term]]
kind = "microfacet"
rho = 0.015
m = 2e-4
n = [3.6, 0.0]
[[term]]
kind = "stripes"
rho = 300.0
a_um = 800.0
b_um = 10.0
c_um = 40.0
[[term]]
kind = "lambertian"
rho = 0.05
)";
}  // namespace

ChartSettings chart_settings(const std::optional<std::string>& measurement, const std::optional<std::string>& model) {
  ChartSettings out;
  if (measurement) {
    const Measurement m = read_measurement(*measurement);
    out.instrument = m.instrument;
    out.pose = m.pose;
  } else {
    out.instrument = parse_instrument(kPaperInstrument, "the paper's instrument");
    out.pose = {20 * kRadPerDeg, 40 * kRadPerDeg};
  }
  out.model = model ? read_model(*model) : parse_model(kPaperModel, "the paper's model");
  return out;
}

Instrument resized(const Instrument& instrument, int columns, int rows) {
  Instrument out = instrument;
  out.columns = columns;
  out.rows = rows;
  out.geometry.pixel_column *= static_cast<double>(instrument.columns) / columns;
  out.geometry.pixel_row *= static_cast<double>(instrument.rows) / rows;
  out.calibration.reset();  // its pixels are others
  return out;
}

synth::Bench bench_of(const Instrument& in) {
  const Geometry<double>& g = in.geometry;
  synth::Bench b;
  b.columns = in.columns;
  b.rows = in.rows;
  b.flip_columns = in.flip_columns;
  b.flip_rows = in.flip_rows;
  b.pitch_um = {g.pixel_column * 1e6, g.pixel_row * 1e6};
  b.distance_mm = g.distance * 1e3;
  b.offset_mm = {g.offset_x * 1e3, g.offset_y * 1e3};
  b.rotation_deg = {g.rotation_pitch * kDegPerRad, g.rotation_yaw * kDegPerRad, g.rotation_roll * kDegPerRad};
  b.arm_zero_deg = g.arm_zero * kDegPerRad;
  b.axis_offset_mm = {g.arm_axis_x * 1e3, g.arm_axis_z * 1e3};
  b.axis_tilt_deg = {g.arm_axis_tilt_x * kDegPerRad, g.arm_axis_tilt_z * kDegPerRad};
  b.stage_zero_deg = g.stage_zero * kDegPerRad;
  b.beam_offset_mm = {g.beam_offset_x * 1e3, g.beam_offset_y * 1e3};
  b.beam_elevation_deg = g.beam_elevation * kDegPerRad;
  b.sample_tilt_deg = g.sample_tilt * kDegPerRad;
  b.sample_height_mm = g.sample_height * 1e3;
  return b;
}

Instrument instrument_of(const synth::Bench& bench) {
  synth::SensorTruth sensor;
  sensor.read_noise_e = 1;
  return parse_instrument(synth::instrument_toml(bench, sensor), "bench");
}

}  // namespace scatmap::tools
