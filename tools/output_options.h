#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "scatmap/base/output_file.h"

namespace scatmap::tools {

/// -o, --force and --json, alike in every verb that writes.
struct OutputOptions {
  std::vector<std::string> targets;
  bool force = false;
  bool json = false;

  /// @param kinds the allowed extensions, first the usual one; empty: a folder
  void add_to(CLI::App& verb, const std::string& what, const std::vector<std::string>& kinds);
  /// Refuses, before any work, targets that could not be written in the end or whose extension is not known.
  void check() const;
  /// Refuses a target that is one of the files it is made from: --force replaces results, not data.
  void keep(const std::vector<std::filesystem::path>& inputs) const;
  Overwrite overwrite() const { return force ? Overwrite::kForce : Overwrite::kKeep; }

 private:
  std::vector<std::string> kinds_;
};

/// Neither NaN nor infinite, both of which CLI::Range lets through in places.
CLI::Validator finite_number();

/// Finite and > 0; unlike CLI::PositiveNumber it says so in words, not as a range up to the largest double.
CLI::Validator positive_number();
/// Finite and >= 0.
CLI::Validator non_negative_number();

/// Refuses a file that is named twice among both lists, by whatever path. @throws Error naming it
void require_distinct(const std::vector<std::string>& files, const std::vector<std::string>& darks);

/// −360 to 360, and not NaN, which CLI::Range lets through.
CLI::Validator angle_range();

/// Lower-case extension with its dot.
std::string extension_of(const std::filesystem::path& path);

}  // namespace scatmap::tools
