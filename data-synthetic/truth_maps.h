#pragma once
#include "data-synthetic/scene.h"
#include "scatmap/base/grid.h"

namespace scatmap::synth {

/// Where the motors really stand: commanded angle plus encoder error.
struct TrueMotors {
  double stage_deg = 0;
  double arm_deg = 0;
};

/// The true motor angles of setting `number` of a scene; settings have independent encoder errors.
TrueMotors true_motors(const Scene& scene, double stage_deg, double arm_deg, std::uint64_t number);

/// What every pixel sees, at its centre; NaN where it sees no lit surface (collected: 0).
struct TruthMaps {
  Grid<double> brdf_per_sr;
  Grid<double> theta_s_deg;
  Grid<double> phi_s_deg;  ///< [0, 360)
  Grid<double> solid_angle_sr;
  Grid<double> collected;  ///< f·Ω·cos θs: the share of the beam's electrons that the pixel gets
};

TruthMaps truth_maps(const Bench& bench, const ModelTruth& model, const TrueMotors& motors);

/// Optical density that a stack of filters really has.
double true_density(const BrdfScene& scene, const FrameStack& stack);

/// Electrons that the whole unobstructed beam makes in one frame of the stack: power × time × 10^−OD.
/// @param relative_power 1 at the signature, 1 + drift in the sample's frames
double beam_electrons(const BrdfScene& scene, const FrameStack& stack, double relative_power);

}  // namespace scatmap::synth
