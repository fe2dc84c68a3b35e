#pragma once
#include <cstddef>
#include <optional>
#include <span>

#include "scatmap/brdf/merge.h"

namespace scatmap {

/// Two exposures that cannot have seen the same scene.
struct Contradiction {
  std::size_t bright, dim;  ///< indices of the exposures
  double ratio;  ///< what the dim one shows of the bright one's light, where either stands out of both noises
};

/// Filters and times are never off by that factor: a shutter that stayed closed, another filter, another scene.
inline constexpr double kContradiction = 4;

/// The worst pair of exposures whose light differs by more than kContradiction, over the pixels good in both where
/// either stands ten standard deviations out of the noise of both; nullopt if there is none, or too little to compare.
std::optional<Contradiction> contradiction(std::span<const ScaledCounts> exposures);

}  // namespace scatmap
