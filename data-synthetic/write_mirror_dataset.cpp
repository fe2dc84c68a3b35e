#include "data-synthetic/random.h"
#include "data-synthetic/random_purpose.h"
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

struct TrueTarget {
  TrueMotors motors;
  PixelPoint centre;
};

TrueTarget true_target(const Scene& scene, std::size_t number) {
  const MirrorTarget& target = scene.mirror->targets[number];
  const MirrorMount& mount = scene.mirror->mounts[target.mount];
  Bench bench = scene.bench;
  bench.sample_tilt_deg = mount.tilt_deg;
  bench.sample_height_mm = mount.height_mm;
  const TrueMotors motors = true_motors(scene, target.stage_deg, target.arm_deg, number);
  const TruthGeometry geometry(bench, motors.stage_deg, motors.arm_deg, target.tilt_deg);
  const auto hit = target.direct ? geometry.direct_hit() : geometry.mirror_hit();
  if (hit && on_sensor(bench, *hit)) return {motors, *hit};
  throw Error({scene.name + ": target " + std::to_string(number + 1),
               "its beam misses the sensor",
               "stage " + number_text(target.stage_deg) + ", arm " + number_text(target.arm_deg) + ", tilt " +
                   number_text(target.tilt_deg),
               {}});
}

std::string row_text(const Scene& scene, const MirrorTarget& target, const TrueMotors& motors, double column_px,
                     double row_px, const std::string& file) {
  const std::string mount = target.direct ? "" : scene.mirror->mounts[target.mount].name;
  return std::string(target.direct ? "direct" : "specular") + "," + number_text(motors.stage_deg) + "," +
         number_text(motors.arm_deg) + "," + number_text(target.tilt_deg) + "," + number_text(column_px) + "," +
         number_text(row_px) + "," + number_text(scene.mirror->sigma_px) + "," + mount +
         (file.empty() ? "" : "," + file) + "\n";
}

std::string write_target_frame(const Scene& scene, std::size_t number, const PixelPoint& centre, FrameWriter& writer) {
  const MirrorTarget& target = scene.mirror->targets[number];
  const auto spot_e = gaussian_spot_e(scene.bench, centre, scene.signature_diameter_mm, scene.mirror->spot_e);
  const double exposure_s = scene.mirror->exposure_s;
  const std::string name = "target_" + std::to_string(1001 + number).substr(1);
  return writer.write(name, "Light Frame", spot_e,
                      {exposure_s, exposure_s, target.stage_deg, target.arm_deg, target.direct ? 0 : target.tilt_deg,
                       target.direct ? "direct" : "specular"});
}

}  // namespace

void write_mirror_dataset(const Scene& scene, const fs::path& folder, const Provenance& provenance) {
  const MirrorScene& mirror = *scene.mirror;
  const std::string header = "kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px,mount";
  std::string measured = header + (mirror.write_frames ? ",file\n" : "\n"), truth = header + "\n";
  std::optional<FrameWriter> writer;
  if (mirror.write_frames) writer.emplace(scene, folder, provenance);
  for (std::size_t i = 0; i < mirror.targets.size(); ++i) {
    const MirrorTarget& target = mirror.targets[i];
    const auto [motors, centre] = true_target(scene, i);
    const auto column_px = static_cast<double>(centre.column_px), row_px = static_cast<double>(centre.row_px);
    const std::string file = writer ? write_target_frame(scene, i, centre, *writer) : "";
    PixelRandom random(random_key(scene.seed, kCentroids, 0), i);
    const double seen_column_px = column_px + mirror.sigma_px * random.normal();
    const double seen_row_px = row_px + mirror.sigma_px * random.normal();
    measured += row_text(scene, target, {target.stage_deg, target.arm_deg}, seen_column_px, seen_row_px, file);
    truth += row_text(scene, target, motors, column_px, row_px, "");
  }
  write_text_file(folder / "targets.csv", measured, Overwrite::kKeep);
  write_text_file(folder / "truth/targets.csv", truth, Overwrite::kKeep);
  std::string mounts = provenance_comment(provenance);
  for (const MirrorMount& m : mirror.mounts) {
    mounts += "\n[[mount]]\nname = \"" + m.name + "\"\ntilt_deg = " + number_text(m.tilt_deg) +
              "\nheight_mm = " + number_text(m.height_mm) + "\n";
  }
  write_text_file(folder / "truth/mounts.toml", mounts, Overwrite::kKeep);
}

}  // namespace scatmap::synth
