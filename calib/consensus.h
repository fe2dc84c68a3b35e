#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "calib/solve.h"

namespace scatmap::calib {

/// Each target's distance from a fit in standard deviations, encoder errors included; infinite where the beam misses.
std::vector<double> distances(const TargetModel& model, const Eigen::VectorXd& values);

/// How badly a fit explains all targets: mean of log(1 + distance²/4), to which a wrong target adds little.
double disagreement(const std::vector<double>& distance);

/// Targets within `reject_sigma` of a fit; where the stated uncertainties are too small for the bulk of the targets,
/// within as many times their own scatter, up to ten times.
Used within(const std::vector<double>& distance, double reject_sigma);

struct Consensus {
  Solution solution;
  Used used;
};

/// Fits, leaves out far targets, takes back near ones, until the set stands still; a robust fit (Cauchy) comes first
/// where the plain one has outliers.
/// @param near  where to begin, e.g. the closed-form start's consensus
/// @param tight see SolveOptions
/// @throws Error if fewer than half of the targets agree with one bench
Consensus consensus(const TargetModel& model, const Used& near, const FitSet& set, const Eigen::VectorXd& start,
                    double reject_sigma, bool tight);

}  // namespace scatmap::calib
