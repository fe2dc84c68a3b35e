#pragma once
#include <Eigen/Core>
#include <random>
#include <vector>

#include "calib/calibrate.h"
#include "data-synthetic/truth_geometry.h"

namespace scatmap::tools {

/// A bench as it is, what the laboratory believes of it, and the targets it shot.
struct TargetSession {
  synth::Bench truth;
  Instrument nominal;
  calib::TargetList list;
};

/// Centroids of 0.05 px, encoders of 0.0005 degrees; every tolerance drawn from the default prior, but the stage's zero
/// from kStageZeroSigma_deg. One target in ten is the direct beam.
TargetSession draw_session(std::size_t targets, std::mt19937_64& rng);
inline constexpr double kStageZeroSigma_deg = 0.002;  // autocollimation

/// Where the detector pixel of `point` really looks, as seen by an instrument: columns and rows from that pixel. NaN
/// where the instrument does not see it.
Eigen::Vector2d direction_error_px(const TargetSession& session, const Instrument& instrument,
                                   const calib::DirectionPoint& point);

}  // namespace scatmap::tools
