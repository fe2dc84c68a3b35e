#include "data-synthetic/scene.h"

#include <array>
#include <cmath>

#include "data-synthetic/scene_tables.h"
#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"
#include "scatmap/base/toml_file.h"

namespace scatmap::synth {
namespace {

constexpr int kMostPixelsPerSide = 32768;

std::array<double, 2> pair_or(const TomlTable& t, const std::string& key, const std::array<double, 2>& fallback,
                              const NumberRange& range = kAnyNumber) {
  if (!t.has(key)) return fallback;
  const auto v = t.numbers(key, 2, range);
  return {v[0], v[1]};
}

int integer_or(const TomlTable& t, const std::string& key, int fallback, int minimum, int maximum) {
  return t.has(key) ? t.integer(key, minimum, maximum) : fallback;
}

void read_detector(const TomlTable& t, Bench& out) {
  out.columns = integer_or(t, "columns", out.columns, 1, kMostPixelsPerSide);
  out.rows = integer_or(t, "rows", out.rows, 1, kMostPixelsPerSide);
  out.pitch_um = pair_or(t, "pitch_um", out.pitch_um, kPositive);
  out.distance_mm = t.number_or("distance_mm", out.distance_mm, kPositive);
  out.offset_mm = pair_or(t, "offset_mm", out.offset_mm);
  if (t.has("rotation_deg")) {
    const auto v = t.numbers("rotation_deg", 3);
    out.rotation_deg = {v[0], v[1], v[2]};
  }
  out.flip_columns = t.boolean_or("flip_columns", out.flip_columns);
  out.flip_rows = t.boolean_or("flip_rows", out.flip_rows);
}

void require_keys(const TomlTable& t, std::initializer_list<const char*> keys) {
  for (const char* key : keys) {
    if (!t.has(key)) throw Error({t.where(key), "is missing", {}, {}});
  }
}

}  // namespace

TomlTable table_or_empty(const TomlTable& table, const std::string& key) {
  return table.optional_table(key).value_or(TomlTable::parse("", key));
}

Bench read_bench(const TomlTable& root, const Bench& start) {
  Bench out = start;
  read_detector(table_or_empty(root, "detector"), out);
  const TomlTable arm = table_or_empty(root, "arm");
  out.arm_zero_deg = arm.number_or("zero_deg", out.arm_zero_deg);
  out.axis_offset_mm = pair_or(arm, "axis_offset_mm", out.axis_offset_mm);
  out.axis_tilt_deg = pair_or(arm, "axis_tilt_deg", out.axis_tilt_deg);
  out.arm_encoder_sigma_deg = arm.number_or("encoder_sigma_deg", out.arm_encoder_sigma_deg, kNotNegative);
  const TomlTable stage = table_or_empty(root, "stage");
  out.stage_zero_deg = stage.number_or("zero_deg", out.stage_zero_deg);
  out.stage_encoder_sigma_deg = stage.number_or("encoder_sigma_deg", out.stage_encoder_sigma_deg, kNotNegative);
  const TomlTable beam = table_or_empty(root, "beam");
  out.beam_elevation_deg = beam.number_or("elevation_deg", out.beam_elevation_deg);
  out.beam_offset_mm = pair_or(beam, "offset_mm", out.beam_offset_mm);
  const TomlTable sample = table_or_empty(root, "sample");
  out.sample_tilt_deg = sample.number_or("tilt_deg", out.sample_tilt_deg);
  out.sample_height_mm = sample.number_or("height_mm", out.sample_height_mm);
  return out;
}

SensorTruth read_sensor(const TomlTable& root, const SensorTruth& start) {
  const TomlTable t = table_or_empty(root, "sensor");
  SensorTruth out = start;
  out.gain_e_per_dn = t.number_or("gain_e_per_dn", out.gain_e_per_dn, kPositive);
  out.read_noise_e = t.number_or("read_noise_e", out.read_noise_e, kNotNegative);
  out.bias_dn = t.number_or("bias_dn", out.bias_dn, kNotNegative);
  out.adc_max_dn = integer_or(t, "adc_max_dn", out.adc_max_dn, 1, 65535);
  out.saturation_dn = t.number_or("saturation_dn", out.saturation_dn, {out.bias_dn, 65535, true});
  out.full_well_e = t.number_or("full_well_e", out.full_well_e, kPositive);
  out.dark_e_per_s = t.number_or("dark_e_per_s", out.dark_e_per_s, kNotNegative);
  out.hot_pixels = integer_or(t, "hot_pixels", out.hot_pixels, 0, 100000000);
  out.hot_e_per_s = t.number_or("hot_e_per_s", out.hot_e_per_s, kNotNegative);
  out.nonlinearity_percent = t.number_or("nonlinearity_percent", out.nonlinearity_percent, {-49, 49, false});
  out.bloom = t.boolean_or("bloom", out.bloom);
  return out;
}

Scene parse_scene(const std::string& text, const std::string& name) {
  const TomlTable root = TomlTable::parse(text, name);
  Scene out;
  out.name = name;
  const std::string kind = root.string("kind");
  out.seed = static_cast<std::uint64_t>(root.integer("seed", 0, 2147483647));
  out.wavelength_nm = root.number("wavelength_nm", kPositive);
  out.date_obs = root.optional_string("date_obs").value_or("2026-01-01T00:00:00");
  require_keys(root.table("detector"), {"columns", "rows", "pitch_um", "distance_mm"});
  require_keys(root.table("sensor"), {"gain_e_per_dn", "read_noise_e", "bias_dn", "saturation_dn"});
  out.bench = read_bench(root, {});
  out.sensor = read_sensor(root, {});
  out.signature_diameter_mm =
      table_or_empty(root, "beam").number_or("signature_diameter_mm", out.signature_diameter_mm, kPositive);
  const TomlTable nominal = table_or_empty(root, "nominal");
  out.nominal_bench = read_bench(nominal, out.bench);
  out.nominal_sensor = read_sensor(nominal, out.sensor);
  root.choice("kind", {"brdf", "mirror", "flats"});
  if (kind == "brdf") out.brdf = read_brdf_scene(root, out.bench, out.wavelength_nm);
  if (kind == "mirror") out.mirror = read_mirror_scene(root, out.bench);
  if (kind == "flats") out.flats = read_flat_scene(root);
  root.reject_unknown_keys();
  return out;
}

Scene read_scene(const std::filesystem::path& path) { return parse_scene(read_text_file(path), path.string()); }

}  // namespace scatmap::synth
