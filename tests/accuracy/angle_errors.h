#pragma once
#include <map>
#include <string>

namespace scatmap::test {

/// The worst of one method in one regime, as a share of its bound.
struct WorstOfMethod {
  long double share_rad = 0, share_px = 0;  ///< error over the frame's bound
  long double error_rad = 0;
  long long samples = 0;
  int frames_unbounded = 0;  ///< `linear` about the pole: no bound, not compared
  int wrong_pixels = 0;      ///< a number where there is none, or none where there is one
};

struct AngleErrors {
  std::map<std::string, WorstOfMethod> methods;
  long double solid_angle_share = 0, cosine_share = 0;  ///< of the `vector` rows
  long double single_solid_angle_share = 0, single_cosine_share = 0;
  /// `exact` against the simulator, which starts from the file's numbers, over kAngleMaxError_rad × spread.
  long double chain_share = 0;
};

/// Frames of one regime through every method of the angle map, `samples` pixels of each frame against long double on
/// the same view (half-angle formulae) and against the simulator.
AngleErrors angle_errors(std::size_t regime, int frames, int samples, unsigned seed);

}  // namespace scatmap::test
