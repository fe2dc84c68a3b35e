#pragma once
#include <string>

#include "scatmap/base/provenance.h"

namespace scatmap::tools {

/// Where a TOML file comes from, in comment lines: program, command line, inputs with their checksums.
inline std::string toml_comment(const Provenance& p) {
  const auto line = [](const std::string& name, std::string text) {
    for (char& c : text) {
      if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) c = ' ';
    }
    return "# " + name + ": " + text + "\n";
  };
  std::string text = line("written by", p.written_by) + line("command", p.command_line);
  for (const InputRecord& i : p.inputs) text += line("input", i.path + " sha256 " + i.sha256);
  return text;
}

}  // namespace scatmap::tools
