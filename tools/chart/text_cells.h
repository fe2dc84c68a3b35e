#pragma once
#include <string>

namespace scatmap::tools {

/// Left-aligned in a column; at least one blank follows.
inline std::string padded(const std::string& text, std::size_t width) {
  return text.size() < width ? text + std::string(width - text.size(), ' ') : text + " ";
}

/// A field of a CSV line (RFC 4180).
inline std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

}  // namespace scatmap::tools
