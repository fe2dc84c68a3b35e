#pragma once
#include <sys/stat.h>

#include <filesystem>

namespace scatmap {

/// What tells whether a file was written to or replaced between two looks at it. Blind to a change that keeps the size
/// and falls into the same tick of the file system's clock (some milliseconds).
struct FileState {
  dev_t device = 0;
  ino_t inode = 0;
  off_t bytes = 0;
  timespec written{};
  timespec changed{};

  bool operator==(const FileState& other) const;
};

/// @throws Error if the file cannot be looked at
FileState file_state(const std::filesystem::path& path);

/// To be called when a file has been read. @throws Error "changed while it was read" if it is not as it was `before`
void require_unchanged(const std::filesystem::path& path, const FileState& before);

}  // namespace scatmap
