#pragma once
#include <Eigen/Core>
#include <optional>
#include <random>
#include <string>

#include "scatmap/angles/instrument.h"
#include "scatmap/brdf/map_uncertainty.h"

/// Scenes of the chain's Monte Carlo and the draws of one trial.
namespace scatmap::test {

enum class ChainCase {
  kOneExposure,      ///< the paper's 59.3 %, a broad lobe, pose uncertain
  kThreeExposures,   ///< tied by overlap, one of them through the signature's stack; the same sample
  kPaperSameStack,   ///< scene overlap-20-0 cut to 96 x 96 pixels around the centre peak; pose known
  kPaperSignatures,  ///< scene signature-20-0 likewise: no sample exposure goes through a stack of the signature
};

/// Relative errors, and errors of OD, that the lab does not know.
struct ChainDraw {
  std::vector<double> od_error = std::vector<double>(8, 0);
  std::vector<double> signature_time_error = std::vector<double>(3, 0), time_error = std::vector<double>(3, 0);
  double laser = 0, nonlinear_percent = 0;
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();
};

/// Every source from the distribution that the scene's lab states.
ChainDraw chain_draw(ChainCase which, std::mt19937_64& rng);
/// What the lab knows of its pose; nothing where it is exactly known.
std::optional<Calibration> chain_calibration(ChainCase which);
/// A scene file for the simulator.
std::string chain_scene(ChainCase which, const ChainDraw& draw, unsigned seed);

struct ChainRegions {
  Region lobe, faint;  ///< bright, dim
  Region left, right;  ///< whose ratio the structured causes move
};
ChainRegions chain_regions(ChainCase which);

}  // namespace scatmap::test
