#pragma once
#include <string>
#include <vector>

#include "calib/directions.h"
#include "calib/linearisation.h"

namespace scatmap::calib {

/// A combination of parameters about which the targets say less than the mechanical tolerances do.
struct BlindDirection {
  std::string
      parameters;  ///< "arm.zero_deg, stage.zero_deg": together, in the proportions that leave every spot in place
  double singular_value = 0;  ///< what the targets say, in units of what the tolerances say; 0 for an exact gauge
  double effect_px = 0;       ///< how far directions move when the combination moves by its tolerance
  std::string remedy;         ///< "add one direct-beam frame", found by trying it; targets first, then what
                              ///< a bench can measure without its camera; empty: nothing that was tried helps
};

struct Observability {
  Eigen::VectorXd singular_values;  ///< of the targets' whitened Jacobian per mechanical tolerance, falling
  std::vector<BlindDirection> blind;
  std::size_t seen() const { return static_cast<std::size_t>(singular_values.size()) - blind.size(); }
};

/// @param at  all parameters that are not held, scale = mechanical tolerance; its priors are not used
Observability observability(const TargetModel& model, const Used& used, const Linearisation& at,
                            const Eigen::VectorXd& values, const DirectionEffects& effects);

/// One sentence for people.
std::string sentence(const BlindDirection& direction);

}  // namespace scatmap::calib
