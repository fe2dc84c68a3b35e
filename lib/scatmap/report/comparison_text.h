#pragma once
#include <string>

#include "scatmap/compare/compare.h"

namespace scatmap {

/// A comparison for machines: peaks, pairs, fringes, residual statistics; numbers with units in their names, null where
/// there is none.
std::string comparison_json(const Comparison& comparison);

/// The same for people, a few lines.
std::string comparison_text(const Comparison& comparison);

}  // namespace scatmap
