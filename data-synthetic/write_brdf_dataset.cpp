#include "data-synthetic/fits_writer.h"
#include "data-synthetic/truth_maps.h"
#include "data-synthetic/write_dataset.h"
#include "data-synthetic/write_frames.h"
#include "data-synthetic/write_toml.h"
#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/output_file.h"

namespace scatmap::synth {
namespace fs = std::filesystem;
namespace {

// Settings of the motors in a "brdf" scene, as true_motors numbers them.
constexpr std::uint64_t kSampleSetting = 0, kSignatureSetting = 1;

Grid<double> scaled(const Grid<double>& values, double factor) {
  Grid<double> out(values.rows(), values.columns());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = values[i] * factor;
  return out;
}

PixelPoint signature_centre(const Scene& scene, const TrueMotors& motors) {
  const auto hit = TruthGeometry(scene.bench, motors.stage_deg, motors.arm_deg).direct_hit();
  if (hit && on_sensor(scene.bench, *hit)) return *hit;
  throw Error({scene.name + ": signature.arm_deg",
               "turns the sensor out of the direct beam",
               number_text(scene.brdf->signature_arm_deg),
               {}});
}

std::string pose_toml(const TrueMotors& sample, const TrueMotors& signature, const PixelPoint& centre) {
  return "stage_deg = " + number_text(sample.stage_deg) + "\narm_deg = " + number_text(sample.arm_deg) +
         "\n\n[signature]\narm_deg = " + number_text(signature.arm_deg) +
         "\ncolumn_px = " + number_text(static_cast<double>(centre.column_px)) +
         "\nrow_px = " + number_text(static_cast<double>(centre.row_px)) + "\n";
}

// The truth's images: TRUTH_BRDF is the primary, the rest are extensions.
void write_truth_fits(const fs::path& path, const Scene& scene, const TruthMaps& maps, const TrueMotors& motors,
                      const Provenance& provenance) {
  const TruthGeometry geometry(scene.bench, motors.stage_deg, motors.arm_deg);
  const auto theta_i_deg = static_cast<double>(geometry.incidence_rad() * 180 / kPi);
  std::vector<FitsCard> cards{{"EXTNAME", std::string("TRUTH_BRDF"), {}},
                              {"BUNIT", std::string("sr-1"), {}},
                              {"THETAI", theta_i_deg, "[deg] angle of incidence"},
                              {"STAGEDEG", motors.stage_deg, "[deg] true stage angle"},
                              {"ARMDEG", motors.arm_deg, "[deg] true arm angle"}};
  for (FitsCard& card : history_cards(provenance)) cards.push_back(std::move(card));
  const auto named = [](const std::string& name, const std::string& unit) {
    return std::vector<FitsCard>{{"EXTNAME", name, {}}, {"BUNIT", unit, {}}};
  };
  FitsWriter file(path);
  file.image(maps.brdf_per_sr, cards);
  file.image(maps.theta_s_deg, named("THETA_S_DEG", "deg"));
  file.image(maps.phi_s_deg, named("PHI_S_DEG", "deg"));
  file.image(maps.solid_angle_sr, named("SOLID_ANGLE_SR", "sr"));
  const BrdfScene& brdf = *scene.brdf;
  for (std::size_t i = 0; i < brdf.exposures.size(); ++i) {
    const double beam_e = beam_electrons(brdf, brdf.exposures[i], 1 + brdf.laser.drift_percent / 100);
    file.image(scaled(maps.collected, beam_e), named("EXPECTED_E_" + std::to_string(i + 1), "electron"));
  }
  file.close();
}

}  // namespace

void write_brdf_dataset(const Scene& scene, const fs::path& folder, const Provenance& provenance) {
  const BrdfScene& brdf = *scene.brdf;
  const TrueMotors motors = true_motors(scene, brdf.stage_deg, brdf.arm_deg, kSampleSetting);
  const TrueMotors signature_motors = true_motors(scene, brdf.stage_deg, brdf.signature_arm_deg, kSignatureSetting);
  const PixelPoint centre = signature_centre(scene, signature_motors);
  const TruthMaps maps = truth_maps(scene.bench, brdf.model, motors);

  FrameWriter writer(scene, folder, provenance);
  std::vector<StackFiles> signatures, exposures;
  for (const FrameStack& stack : brdf.signatures) {
    const auto spot_e =
        gaussian_spot_e(scene.bench, centre, scene.signature_diameter_mm, beam_electrons(brdf, stack, 1));
    const std::string name =
        brdf.signatures.size() < 2 ? "signature" : "signature" + std::to_string(signatures.size() + 1);
    signatures.push_back(writer.write_stack(name, spot_e, stack, brdf.stage_deg, brdf.signature_arm_deg));
  }
  for (const FrameStack& stack : brdf.exposures) {
    const double beam_e = beam_electrons(brdf, stack, 1 + brdf.laser.drift_percent / 100);
    const std::string name = "exposure" + std::to_string(exposures.size() + 1);
    exposures.push_back(writer.write_stack(name, scaled(maps.collected, beam_e), stack, brdf.stage_deg, brdf.arm_deg));
  }
  const std::string comment = provenance_comment(provenance) + "\n";
  write_text_file(folder / "measurement.toml", comment + measurement_toml(scene, signatures, exposures),
                  Overwrite::kKeep);
  write_text_file(folder / "model.toml", comment + model_toml(brdf.model), Overwrite::kKeep);
  write_text_file(folder / "truth/pose.toml", comment + pose_toml(motors, signature_motors, centre), Overwrite::kKeep);
  write_truth_fits(folder / "truth/brdf.fits", scene, maps, motors, provenance);
}

}  // namespace scatmap::synth
