#pragma once
#include <string>

#include "scatmap/base/provenance.h"
#include "scatmap/compare/compare.h"

namespace scatmap {

/// A comparison for machines: peaks, pairs, fringes, residual statistics; numbers with units in their names, null where
/// there is none; program, command and inputs.
std::string comparison_json(const Comparison& comparison, const Provenance& provenance);

/// The same for people, a few lines.
std::string comparison_text(const Comparison& comparison);

}  // namespace scatmap
