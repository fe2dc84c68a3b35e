#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace scatmap {

enum class Overwrite { kKeep, kForce };

/// An output that appears whole or not at all: written under a temporary name beside its target, then renamed. Dropped
/// without commit() (an exception, say) it leaves nothing behind and the old file intact.
class OutputFile {
 public:
  /// @throws Error if the target exists and Overwrite is kKeep, is a folder, or its folder does not exist.
  OutputFile(std::filesystem::path target, Overwrite overwrite);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Where to write; does not exist yet. In the target's folder, with the target's extension.
  const std::filesystem::path& temporary() const { return temporary_; }
  const std::filesystem::path& target() const { return target_; }
  /// Flushes to disk and renames. @throws Error if the disk is full or the rename fails.
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  Overwrite overwrite_;
  bool committed_ = false;
};

/// Writes text to `target` through OutputFile. @throws Error
void write_text_file(const std::filesystem::path& target, std::string_view text, Overwrite overwrite);

/// Whole content of a text file of at most `limit_bytes`. @throws Error naming the file
std::string read_text_file(const std::filesystem::path& path, std::size_t limit_bytes = std::size_t{16} << 20);

}  // namespace scatmap
