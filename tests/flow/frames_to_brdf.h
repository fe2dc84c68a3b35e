#pragma once
#include <filesystem>
#include <string>
#include <vector>

/// Simulated raw frames through the whole chain, against the simulator's truth, binned by expected counts.
namespace scatmap::test {

struct Bin {
  double low_e = 0, high_e = 0;  ///< expected net electrons per frame of the most sensitive unsaturated exposure
  double pixels = 0;
  double square = 0;       ///< Σ ((measured − truth)/u_random)²
  double error = 0;        ///< Σ (measured − truth)
  double truth = 0;        ///< Σ truth
  double variance = 0;     ///< Σ u_random²
  double u_signature = 0;  ///< relative, common to all pixels of one run: the largest
};

/// Simulates the scene with each seed, reduces it with what the lab would know plus the true geometry and true filters
/// (so that only random errors remain), and bins all pixels with mask 0.
std::vector<Bin> frames_to_brdf(const std::string& scene, const std::vector<unsigned>& seeds);

}  // namespace scatmap::test
