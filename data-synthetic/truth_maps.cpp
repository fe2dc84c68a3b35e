#include "data-synthetic/truth_maps.h"

#include <algorithm>
#include <limits>

#include "data-synthetic/random.h"
#include "data-synthetic/random_purpose.h"
#include "data-synthetic/truth_geometry.h"
#include "scatmap/base/parallel.h"

namespace scatmap::synth {
namespace {

void fill_row(const TruthGeometry& geometry, const ModelTruth& model, int row, TruthMaps& maps) {
  const Vec3 to_source = geometry.to_source();
  for (int c = 0; c < maps.collected.columns(); ++c) {
    const auto pixel = geometry.pixel(c, row);
    if (!pixel) continue;
    const long double brdf_per_sr = scatmap::synth::brdf_per_sr(model, to_source, pixel->direction);
    maps.brdf_per_sr(row, c) = static_cast<double>(brdf_per_sr);
    maps.theta_s_deg(row, c) = static_cast<double>(pixel->theta_s_rad * 180 / kPi);
    const auto phi_s_deg = static_cast<double>(pixel->phi_s_rad * 180 / kPi);
    maps.phi_s_deg(row, c) = phi_s_deg >= 360 ? 0 : phi_s_deg;
    maps.solid_angle_sr(row, c) = static_cast<double>(pixel->solid_angle_sr);
    maps.collected(row, c) = static_cast<double>(brdf_per_sr * pixel->solid_angle_sr * pixel->direction.z);
  }
}

}  // namespace

TrueMotors true_motors(const Scene& scene, double stage_deg, double arm_deg, std::uint64_t number) {
  PixelRandom random(random_key(scene.seed, kEncoders, 0), number);
  const double stage_error_deg = scene.bench.stage_encoder_sigma_deg * random.normal();
  const double arm_error_deg = scene.bench.arm_encoder_sigma_deg * random.normal();
  return {stage_deg + stage_error_deg, arm_deg + arm_error_deg};
}

TruthMaps truth_maps(const Bench& bench, const ModelTruth& model, const TrueMotors& motors) {
  const TruthGeometry geometry(bench, motors.stage_deg, motors.arm_deg);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Grid<double> unseen(bench.rows, bench.columns, nan);
  TruthMaps maps{unseen, unseen, unseen, unseen, Grid<double>(bench.rows, bench.columns, 0)};
  for_each_row(bench.rows, [&](int row) { fill_row(geometry, model, row, maps); });
  return maps;
}

double true_density(const BrdfScene& scene, const FrameStack& stack) {
  double sum = 0;
  for (const NdFilter& filter : scene.filters) {
    if (std::find(stack.filters.begin(), stack.filters.end(), filter.name) != stack.filters.end())
      sum += filter.true_od;
  }
  return sum;
}

double beam_electrons(const BrdfScene& scene, const FrameStack& stack, double relative_power) {
  const double unfiltered_e = scene.laser.electrons_per_s * relative_power * stack.true_exposure_s;
  return unfiltered_e * std::pow(10.0, -true_density(scene, stack));
}

}  // namespace scatmap::synth
