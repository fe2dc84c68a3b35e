#include "tools/chart/angle_regimes.h"

namespace scatmap::tools {
namespace {

synth::Bench plain_bench() {
  synth::Bench b;
  b.columns = 97;
  b.rows = 61;
  b.pitch_um = {140, 200};  // a frame as large as the paper's
  b.distance_mm = 325;
  return b;
}

template <class Change>
AngleSetup with(double stage_deg, double arm_deg, Change change) {
  AngleSetup s{plain_bench(), stage_deg, arm_deg};
  change(s.bench);
  return s;
}
AngleSetup at(double stage_deg, double arm_deg) {
  return with(stage_deg, arm_deg, [](synth::Bench&) {});
}

}  // namespace

std::vector<AngleRegime> angle_regimes() {
  using Bench = synth::Bench;
  return {
      {"paper's bench, theta_i 20 deg", at(20, 40)},
      {"theta_s = 0 in the frame (phi undefined)", at(20, 20)},
      {"theta_s = 0 at a pixel's centre", with(20, 20,
                                               [](Bench& b) {
                                                 b.offset_mm = {0, 0};
                                               })},
      {"phi at its seam", at(20, 14)},
      {"theta_s through 90 deg in the frame", at(50, 139.5)},
      {"theta_s beyond 90 deg everywhere", at(50, 150)},
      {"theta_i = 0", at(0, 10)},
      {"theta_i = 1e-9 deg", at(1e-9, 10)},
      {"theta_i = 89.9 deg", at(89.9, 150)},
      {"theta_i = 90 deg", at(90, 150)},
      {"retro-reflection", at(30, 0)},
      {"straight-through beam, sample edge-on", at(89, 178)},
      {"detector edge-on", with(20, 40,
                                [](Bench& b) {
                                  b.rotation_deg = {0, 90, 0};
                                })},
      {"detector nearly edge-on", with(20, 40,
                                       [](Bench& b) {
                                         b.rotation_deg = {0, 89.99, 0};
                                       })},
      {"detector from behind", with(20, 40,
                                    [](Bench& b) {
                                      b.rotation_deg = {0, 180, 0};
                                    })},
      {"roll 90 deg", with(20, 40,
                           [](Bench& b) {
                             b.rotation_deg = {0, 0, 90};
                           })},
      {"roll 180 deg", with(20, 40,
                            [](Bench& b) {
                              b.rotation_deg = {0, 0, 180};
                            })},
      {"rotation by 1e-12 deg", with(20, 40,
                                     [](Bench& b) {
                                       b.rotation_deg = {1e-12, 1e-12, 1e-12};
                                     })},
      {"R = 1 um", with(20, 40, [](Bench& b) { b.distance_mm = 1e-3; })},
      {"R = 1 km", with(20, 40, [](Bench& b) { b.distance_mm = 1e6; })},
      {"pitch 0.1 um", with(20, 40,
                            [](Bench& b) {
                              b.pitch_um = {0.1, 0.1};
                            })},
      {"pitch 1 mm", with(20, 40,
                          [](Bench& b) {
                            b.pitch_um = {1000, 1000};
                          })},
      {"flips, every parameter non-zero", with(35, 68,
                                               [](Bench& b) {
                                                 b.flip_columns = b.flip_rows = true;
                                                 b.offset_mm = {1.2, -3.4};
                                                 b.rotation_deg = {2, -3, 7};
                                                 b.arm_zero_deg = 0.3;
                                                 b.stage_zero_deg = -0.2;
                                                 b.axis_offset_mm = {0.4, -0.7};
                                                 b.axis_tilt_deg = {0.2, -0.1};
                                                 b.beam_elevation_deg = 0.4;
                                                 b.beam_offset_mm = {0.5, 0.6};
                                                 b.sample_tilt_deg = -0.6;
                                                 b.sample_height_mm = 0.9;
                                               })},
      {"spot 50 mm off the axis", with(20, 40,
                                       [](Bench& b) {
                                         b.beam_offset_mm = {50, 20};
                                       })},
      {"one pixel", with(20, 40, [](Bench& b) { b.columns = b.rows = 1; })},
      {"one row", with(20, 40, [](Bench& b) { b.rows = 1; })},
      {"one column", with(20, 40, [](Bench& b) { b.columns = 1; })},
      {"row of 16384 pixels", with(20, 40,
                                   [](Bench& b) {
                                     b.columns = 16384;
                                     b.rows = 3;
                                     b.pitch_um = {5.5, 5.5};
                                   })},
  };
}

synth::TruthGeometry truth_of(const AngleSetup& s) { return synth::TruthGeometry(s.bench, s.stage_deg, s.arm_deg); }

bool is_impossible(const AngleSetup& s) {
  const auto pixel = truth_of(s).pixel(s.bench.columns / 2, s.bench.rows / 2);
  if (!pixel) return true;
  const double face_on_sr =
      s.bench.pitch_um[0] * s.bench.pitch_um[1] / (s.bench.distance_mm * s.bench.distance_mm) * 1e-6;
  return static_cast<double>(pixel->solid_angle_sr) < 1e-12 * face_on_sr;
}

}  // namespace scatmap::tools
