#include "tools/output_options.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "scatmap/base/error.h"

namespace scatmap::tools {

std::string extension_of(const std::filesystem::path& path) {
  std::string e = path.extension().string();
  std::transform(e.begin(), e.end(), e.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return e;
}

void OutputOptions::add_to(CLI::App& verb, const std::string& what, const std::vector<std::string>& kinds) {
  kinds_ = kinds;
  CLI::Option* output = verb.add_option("-o,--output", targets, what)->required()->allow_extra_args(false);
  if (kinds.empty()) output->expected(1);
  verb.add_flag("--force", force, "replace existing files");
  verb.add_flag("--json", json, "print the result as JSON on standard output");
}

CLI::Validator finite_number() {
  return CLI::Validator(
      [](std::string& text) {
        double value = 0;
        const bool ok = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
        return ok ? std::string() : "'" + text + "' is not a finite number";
      },
      "");
}

namespace {

CLI::Validator number_from_zero(bool zero_too) {
  const std::string wanted = zero_too ? "a number >= 0" : "a number > 0";
  return CLI::Validator(
      [zero_too, wanted](std::string& text) {
        double value = 0;
        const bool ok =
            CLI::detail::lexical_cast(text, value) && std::isfinite(value) && (zero_too ? value >= 0 : value > 0);
        return ok ? std::string() : "'" + text + "' must be " + wanted;
      },
      wanted.substr(2));
}

}  // namespace

CLI::Validator positive_number() { return number_from_zero(false); }
CLI::Validator non_negative_number() { return number_from_zero(true); }

void require_distinct(const std::vector<std::string>& files, const std::vector<std::string>& darks) {
  std::set<std::filesystem::path> seen;
  for (const auto* list : {&files, &darks}) {
    for (const std::string& f : *list) {
      if (!seen.insert(std::filesystem::weakly_canonical(std::filesystem::absolute(f))).second)
        throw Error({f, "is given twice", {}, "each frame once"});
    }
  }
}

CLI::Validator angle_range() {
  return CLI::Validator(
      [](std::string& text) {
        double value = 0;
        const bool ok = CLI::detail::lexical_cast(text, value) && value >= -360 && value <= 360;
        return ok ? std::string() : "'" + text + "' is not an angle from -360 to 360 degrees";
      },
      "DEG in [-360, 360]");
}

void OutputOptions::check() const {
  std::set<std::filesystem::path> seen;
  for (const std::string& t : targets) {
    const std::string extension = extension_of(t);
    if (std::find(kinds_.begin(), kinds_.end(), extension) == kinds_.end()) {
      std::string wanted;
      for (const std::string& k : kinds_) wanted += (wanted.empty() ? "" : " or ") + k;
      throw Error({t, "has an extension that says no format of this output", "'" + extension + "'", wanted});
    }
    const OutputFile probe(t, overwrite());  // writes nothing
    if (!seen.insert(std::filesystem::weakly_canonical(std::filesystem::absolute(t))).second)
      throw Error({t, "is named twice as output", {}, {}});
  }
}

void OutputOptions::keep(const std::vector<std::filesystem::path>& inputs) const {
  for (const std::string& target : targets) {
    for (const std::filesystem::path& input : inputs) {
      std::error_code absent;  // then it is no file of the other's
      if (std::filesystem::equivalent(target, input, absent))
        throw Error({target, "is an input of this run, which even --force does not replace", {}, "another name"});
    }
  }
}

}  // namespace scatmap::tools
