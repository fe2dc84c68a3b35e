#include "data-synthetic/write_toml.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <span>

#include "scatmap/base/number_text.h"

namespace scatmap::synth {
namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      std::array<char, 8> escape{};
      std::snprintf(escape.data(), escape.size(), "\\u%04x", static_cast<unsigned>(c));
      out += escape.data();
    } else {
      out += c;
    }
  }
  return out + '"';
}

// A key as TOML wants it: bare where it may be.
std::string key_text(const std::string& name) {
  const auto bare = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_'; };
  return std::all_of(name.begin(), name.end(), bare) ? name : quoted(name);
}

std::string line(const std::string& key, double value) { return key + " = " + number_text(value) + "\n"; }
std::string line(const std::string& key, bool value) { return key + (value ? " = true\n" : " = false\n"); }
std::string line(const std::string& key, const std::string& value) { return key + " = " + quoted(value) + "\n"; }

std::string line(const std::string& key, std::span<const double> values) {
  std::string out = key + " = [";
  for (std::size_t i = 0; i < values.size(); ++i) out += (i == 0 ? "" : ", ") + number_text(values[i]);
  return out + "]\n";
}

std::string line(const std::string& key, const std::vector<std::string>& values) {
  std::string out = key + " = [";
  for (std::size_t i = 0; i < values.size(); ++i) out += (i == 0 ? "" : ", ") + quoted(values[i]);
  return out + "]\n";
}

std::string stack_toml(const FrameStack& stack, const StackFiles& files) {
  std::string out = line("exposure_s", stack.exposure_s) + line("filters", stack.filters);
  if (stack.u_exposure_percent) out += line("u_exposure_percent", *stack.u_exposure_percent);
  return out + line("frames", files.frames) + line("darks", files.darks);
}

std::string term_toml(const Term& t) {
  std::string out = "\n[[term]]\n";
  switch (t.kind) {
    case TermKind::kMicrofacet:
      out += line("kind", std::string("microfacet")) + line("rho", t.rho) + line("m", t.m);
      out += line("n", std::array{t.n_re, t.n_im});
      if (t.dtheta_deg != 0 || t.dphi_deg != 0) out += line("dtheta_deg", t.dtheta_deg) + line("dphi_deg", t.dphi_deg);
      return out;
    case TermKind::kStripes:
      out += line("kind", std::string("stripes")) + line("rho", t.rho);
      out += line("a_um", t.a_um) + line("b_um", t.b_um) + line("c_um", t.c_um);
      return out + line("form", std::string(t.grating ? "grating" : "paper"));
    case TermKind::kLambertian:
      break;
  }
  return out + line("kind", std::string("lambertian")) + line("rho", t.rho);
}

std::string name_of(Polarization polarization) {
  if (polarization == Polarization::kUnpolarized) return "unpolarized";
  return polarization == Polarization::kS ? "s" : "p";
}

}  // namespace

std::string provenance_comment(const Provenance& provenance) {
  std::string text = "# Written by " + provenance.written_by + "\n# Command: " + provenance.command_line;
  for (const InputRecord& input : provenance.inputs) text += "\n# Input: " + input.path + " sha256 " + input.sha256;
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool own_line_break = text.compare(i, 3, "\n# ") == 0;
    const bool control = static_cast<unsigned char>(text[i]) < 0x20 || text[i] == 0x7f;
    out += control && !own_line_break ? ' ' : text[i];
  }
  return out + "\n";
}

std::string instrument_toml(const Bench& bench, const SensorTruth& sensor) {
  std::string out =
      "[detector]\ncolumns = " + std::to_string(bench.columns) + "\nrows = " + std::to_string(bench.rows) + "\n";
  out += line("pitch_um", bench.pitch_um) + line("distance_mm", bench.distance_mm);
  out += line("offset_mm", bench.offset_mm) + line("rotation_deg", bench.rotation_deg);
  out += line("flip_columns", bench.flip_columns) + line("flip_rows", bench.flip_rows);
  out += "\n[arm]\n" + line("zero_deg", bench.arm_zero_deg) + line("axis_offset_mm", bench.axis_offset_mm);
  out += line("axis_tilt_deg", bench.axis_tilt_deg) + line("encoder_sigma_deg", bench.arm_encoder_sigma_deg);
  out += "\n[stage]\n" + line("zero_deg", bench.stage_zero_deg);
  out += line("encoder_sigma_deg", bench.stage_encoder_sigma_deg);
  out += "\n[beam]\n" + line("elevation_deg", bench.beam_elevation_deg) + line("offset_mm", bench.beam_offset_mm);
  out += "\n[sample]\n" + line("tilt_deg", bench.sample_tilt_deg) + line("height_mm", bench.sample_height_mm);
  out += "\n[sensor]\n" + line("gain_e_per_dn", sensor.gain_e_per_dn) + line("read_noise_e", sensor.read_noise_e);
  out += line("saturation_dn", sensor.saturation_dn) + line("bias_dn", sensor.bias_dn);
  return out + line("nonlinearity_percent", std::fabs(sensor.nonlinearity_percent));
}

std::string measurement_toml(const Scene& scene, const std::vector<StackFiles>& signatures,
                             const std::vector<StackFiles>& exposures) {
  const BrdfScene& brdf = *scene.brdf;
  std::string out = line("instrument", std::string("instrument.toml")) + line("wavelength_nm", scene.wavelength_nm);
  out += line("stage_deg", brdf.stage_deg) + line("arm_deg", brdf.arm_deg);
  out += "\n[laser]\n" + line("drift_percent", brdf.laser.drift_tolerance_percent);
  for (const NdFilter& filter : brdf.filters) {
    out += "\n[filters." + key_text(filter.name) + "]\n" + line("od", filter.od) +
           line(filter.tolerance_key, filter.tolerance);
  }
  out += "\n[signature]\n" + line("arm_deg", brdf.signature_arm_deg);
  for (std::size_t j = 0; j < signatures.size(); ++j) {
    if (signatures.size() > 1) out += "\n[[signature.exposure]]\n";
    out += stack_toml(brdf.signatures[j], signatures[j]);
  }
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    out += "\n[[exposure]]\n" + stack_toml(brdf.exposures[i], exposures[i]);
  }
  return out;
}

std::string model_toml(const ModelTruth& model) {
  std::string out = line("wavelength_nm", model.wavelength_nm) + line("polarization", name_of(model.polarization));
  out += line("phi_ref_deg", model.phi_ref_deg);
  for (const Term& term : model.terms) out += term_toml(term);
  return out;
}

}  // namespace scatmap::synth
