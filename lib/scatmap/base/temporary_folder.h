#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

namespace scatmap {

/// A hidden folder (.scatmap-tmp-XXXXXX) in which an output is written before it is renamed to its place. Removed with
/// all it holds by the destructor, and by the system's next writer if this process is killed: it is locked (flock) as
/// long as this process lives, and making one first removes those in the same place, of the same user, that nobody
/// locks. Where the file system has no locks (some network mounts) nothing of others is removed.
class TemporaryFolder {
 public:
  /// @param parent the folder to make it in; target: the output, for messages. @throws Error
  TemporaryFolder(const std::filesystem::path& parent, const std::string& target);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;
  std::unique_ptr<std::byte[]> reserve_;  // memory for removing it when there is no other
};

/// Takes away all temporary folders of this process, with what they hold, and stops every thread that makes or drops
/// one from then on. For a thread that is about to end the process because of a signal; not for a signal handler.
void abandon_temporary_folders() noexcept;

}  // namespace scatmap
