#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "scatmap/base/temporary_folder.h"

namespace scatmap {

enum class Overwrite { kKeep, kForce };

/// An output that appears whole or not at all: written in a TemporaryFolder beside its target, then renamed. Dropped
/// without commit() (an exception, say) it leaves nothing behind and the old file intact; so does a process that is
/// killed, but for a leftover that the next output in the same folder removes. Of two processes that write one target
/// at the same time one wins whole.
class OutputFile {
 public:
  /// @throws Error if the target exists and Overwrite is kKeep, is a folder, or its folder does not exist or cannot be
  /// written to.
  OutputFile(std::filesystem::path target, Overwrite overwrite);

  /// Where to write; does not exist yet. Has the target's name.
  const std::filesystem::path& temporary() const { return temporary_; }
  const std::filesystem::path& target() const { return target_; }
  /// Flushes to disk and renames. @throws Error if the disk is full or the rename fails.
  void commit();

 private:
  std::filesystem::path target_;
  Overwrite overwrite_;
  TemporaryFolder folder_;
  std::filesystem::path temporary_;
};

/// Writes text to `target` through OutputFile. @throws Error
void write_text_file(const std::filesystem::path& target, std::string_view text, Overwrite overwrite);

/// Renames `from` to `to` in one step; with kKeep only if `to` does not exist, or is an empty folder.
/// @throws Error naming `to`
void rename_whole(const std::filesystem::path& from, const std::filesystem::path& to, Overwrite overwrite);

/// Whole content of a text file of at most `limit_bytes`. @throws Error naming the file
std::string read_text_file(const std::filesystem::path& path, std::size_t limit_bytes = std::size_t{16} << 20);

}  // namespace scatmap
