#pragma once
#include <string>

#include <nlohmann/json.hpp>

namespace scatmap::tools {

/// Every promise of every method as a Markdown table; docs/methods.md quotes it, and a test holds the two together.
std::string bounds_table();
/// The same rows as JSON objects.
nlohmann::json bounds_json();

}  // namespace scatmap::tools
