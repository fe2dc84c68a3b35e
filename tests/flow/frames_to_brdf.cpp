#include "tests/flow/frames_to_brdf.h"

#include <unistd.h>

#include <cmath>

#include "data-synthetic/scene.h"
#include "data-synthetic/simulate.h"
#include "scatmap/base/units.h"
#include "scatmap/brdf/from_frames.h"
#include "scatmap/report/fits_file.h"

namespace scatmap::test {
namespace {

namespace fs = std::filesystem;

// Two bins per decade; the first holds everything below 0.1 electrons.
std::vector<Bin> empty_bins() {
  std::vector<Bin> bins{{0, 0.1}};
  for (double low = 0.1; low < 1e6; low *= std::sqrt(10.0)) bins.push_back({low, low * std::sqrt(10.0)});
  return bins;
}

// Scale, pose and non-linearity are other kinds of error: here they are set to the truth.
Measurement with_true_instrument(const fs::path& folder, const synth::Scene& scene) {
  Measurement m = read_measurement(folder / "measurement.toml");
  m.instrument.geometry = read_instrument(folder / "truth" / "instrument.toml").geometry;
  // The encoders' errors go into the zeros: the commanded angles must stay those of the frames' headers.
  const TomlTable pose = TomlTable::read(folder / "truth" / "pose.toml");
  m.instrument.geometry.stage_zero += pose.number("stage_deg") * kRadPerDeg - m.pose.stage_rad;
  m.instrument.geometry.arm_zero += pose.number("arm_deg") * kRadPerDeg - m.pose.arm_rad;
  const synth::BrdfScene& truth = *scene.brdf;
  for (const synth::NdFilter& f : truth.filters) m.filters.at(f.name).od = f.true_od;
  const double p = scene.sensor.nonlinearity_percent / 100, range = scene.sensor.saturation_dn - scene.sensor.bias_dn;
  if (p != 0)
    m.instrument.sensor.linearity = {-p / range, 2 * p * p / (range * range), -5 * p * p * p / (range * range * range)};
  return m;
}

// What the lab cannot know and this test takes out: the laser's drift and the shutter's error, common to an exposure.
double known_factor(const synth::BrdfScene& scene) {
  const synth::FrameStack& e = scene.exposures.front();
  return (1 + scene.laser.drift_percent / 100) * (e.true_exposure_s / e.exposure_s) /
         (scene.signatures.front().true_exposure_s / scene.signatures.front().exposure_s);
}

std::string with_seed(std::string scene, unsigned seed) {
  const auto line = scene.find("seed = ");
  return scene.replace(line, scene.find('\n', line) - line, "seed = " + std::to_string(seed));
}

void add_run(const std::string& scene_name, unsigned seed, std::vector<Bin>& bins) {
  const fs::path folder = fs::temp_directory_path() / ("scatmap-flow-" + scene_name + "-" + std::to_string(getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  const fs::path scene_file = folder / "scene.toml";
  const std::string text =
      read_text_file(fs::path(SCATMAP_SOURCE_DIR) / "data-synthetic" / "scenes" / (scene_name + ".toml"));
  write_text_file(scene_file, with_seed(text, seed), Overwrite::kForce);
  synth::simulate(scene_file, folder / "data", Overwrite::kKeep, {});
  const synth::Scene scene = synth::read_scene(scene_file);
  const BrdfResult result = brdf_from_frames(with_true_instrument(folder / "data", scene), {}, FilterValues::kNominal);

  FitsReader truth(folder / "data" / "truth" / "brdf.fits");
  const Grid<double> expected_f = truth.image_double("TRUTH_BRDF");
  std::vector<Grid<double>> expected_e;
  for (std::size_t e = 0; e < scene.brdf->exposures.size(); ++e)
    expected_e.push_back(truth.image_double("EXPECTED_E_" + std::to_string(e + 1)));
  const double factor = known_factor(*scene.brdf),
               full = (scene.sensor.saturation_dn - scene.sensor.bias_dn) * scene.sensor.gain_e_per_dn;
  for (std::size_t i = 0; i < expected_f.size(); ++i) {
    if (result.map.mask[i] != 0) continue;
    double electrons = 0;
    for (const auto& e : expected_e) electrons = e[i] < 0.9 * full ? std::max(electrons, e[i]) : electrons;
    const double u = result.map.u_random_per_sr[i], error = result.map.brdf_per_sr[i] - expected_f[i] * factor;
    for (Bin& b : bins) {
      if (!(electrons >= b.low_e && electrons < b.high_e)) continue;
      b.pixels += 1;
      b.square += error * error / (u * u);
      b.error += error;
      b.truth += expected_f[i] * factor;
      b.variance += u * u;
      b.u_signature = std::max(b.u_signature, result.signature.u_rate_dn_per_s / result.signature.rate_dn_per_s);
    }
  }
  fs::remove_all(folder);
}

}  // namespace

std::vector<Bin> frames_to_brdf(const std::string& scene, const std::vector<unsigned>& seeds) {
  std::vector<Bin> bins = empty_bins();
  for (const unsigned seed : seeds) add_run(scene, seed, bins);
  return bins;
}

}  // namespace scatmap::test
