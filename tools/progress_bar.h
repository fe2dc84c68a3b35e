#pragma once
#include "scatmap/base/progress.h"

namespace scatmap::tools {

/// Draws on standard error when that is a terminal, otherwise says nothing.
Progress progress_bar(const std::string& verb);

}  // namespace scatmap::tools
