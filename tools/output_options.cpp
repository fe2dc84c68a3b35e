#include "tools/output_options.h"

#include <algorithm>
#include <cctype>

#include "scatmap/base/error.h"

namespace scatmap::tools {

std::string extension_of(const std::filesystem::path& path) {
  std::string e = path.extension().string();
  std::transform(e.begin(), e.end(), e.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return e;
}

void OutputOptions::add_to(CLI::App& verb, const std::string& what, const std::vector<std::string>& kinds) {
  kinds_ = kinds;
  verb.add_option("-o,--output", targets, what)->required()->expected(1, kinds.empty() ? 1 : 8);
  verb.add_flag("--force", force, "replace existing files");
  verb.add_flag("--json", json, "print the result as JSON on standard output");
}

void OutputOptions::check() const {
  for (const std::string& t : targets) {
    const std::string extension = extension_of(t);
    if (std::find(kinds_.begin(), kinds_.end(), extension) == kinds_.end()) {
      std::string wanted;
      for (const std::string& k : kinds_) wanted += (wanted.empty() ? "" : " or ") + k;
      throw Error({t, "has an extension that says no format of this output", "'" + extension + "'", wanted});
    }
    const OutputFile probe(t, overwrite());  // writes nothing
  }
}

}  // namespace scatmap::tools
