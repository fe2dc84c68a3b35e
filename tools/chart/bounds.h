#pragma once
#include <string>

namespace scatmap::tools {

/// Every promise of every method as a Markdown table; docs/methods.md quotes it, and a test holds the two together.
std::string bounds_table();

}  // namespace scatmap::tools
