#pragma once
#include <filesystem>

#include "scatmap/base/output_file.h"

namespace scatmap {

/// In every folder: what was written there, one path a line.
inline constexpr const char* kContents = ".files-of-scatmap";

/// A folder that appears whole or not at all: filled in a TemporaryFolder beside its target, then renamed; one that it
/// replaces changes places with it in one step. Dropped without commit() it leaves nothing behind and what was there
/// intact; a killed process does too, but for a leftover that the next output in the same place removes.
class OutputFolder {
 public:
  /// `marker`: a file, relative to the folder, that every folder of this kind holds.
  /// @throws Error if the target exists, is not empty and Overwrite is kKeep; if it is no folder; if kForce would
  /// replace a folder without the marker, or one with files that its own list (kContents) does not name (somebody's
  /// data); if its parent does not exist
  OutputFolder(const std::filesystem::path& target, std::filesystem::path marker, Overwrite overwrite);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to write; exists and is empty.
  const std::filesystem::path& temporary() const { return temporary_; }
  const std::filesystem::path& target() const { return target_; }
  /// @throws Error
  void commit();

 private:
  void refuse_existing() const;

  std::filesystem::path target_;
  std::filesystem::path marker_;
  Overwrite overwrite_;
  TemporaryFolder folder_;
  std::filesystem::path temporary_;
};

}  // namespace scatmap
