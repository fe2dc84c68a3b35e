#pragma once

namespace scatmap {

/// exp(x) is exactly 0 in double for every x below this: what it multiplies need not be computed.
inline constexpr double kExponentOfZero = -745.2;

}  // namespace scatmap
