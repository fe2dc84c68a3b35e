#include "scatmap/base/temporary_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <mutex>
#include <set>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "scatmap/base/error.h"

namespace scatmap {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPrefix = ".scatmap-tmp-";
constexpr std::size_t kReserveBytes = std::size_t{512} << 10;  // enough to list a folder

// What this process has open, for abandon_temporary_folders(); never destroyed, for a signal may come after main.
struct Registry {
  std::mutex mutex;
  std::set<fs::path> folders;
  std::set<fs::path> swept;  // places whose leftovers were removed
};

Registry& registry() {
  static Registry& all = *new Registry;
  return all;
}

class Descriptor {
 public:
  explicit Descriptor(const fs::path& folder)
      : fd_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC)) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  int release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

// A lock counts only while the name still leads to what is locked, and what other users left is theirs.
bool is_ours(int fd, const fs::path& path) {
  struct stat by_fd {
  }, by_name{};
  return fstat(fd, &by_fd) == 0 && lstat(path.c_str(), &by_name) == 0 && by_fd.st_ino == by_name.st_ino &&
         by_fd.st_dev == by_name.st_dev && by_fd.st_uid == geteuid();
}

// With one open file at a time, for there may be no second. @return whether it is gone
bool remove_tree(const fs::path& folder) {
  std::error_code failed;
  std::vector<fs::directory_entry> entries;
  for (fs::directory_iterator i(folder, failed), end; !failed && i != end; i.increment(failed)) entries.push_back(*i);
  for (const fs::directory_entry& e : entries) {
    if (fs::is_directory(e.symlink_status(failed))) {
      remove_tree(e.path());
    } else {
      unlink(e.path().c_str());
    }
  }
  return rmdir(folder.c_str()) == 0 || errno == ENOENT;
}

void remove_if_abandoned(const fs::path& folder) {
  const Descriptor fd(folder);
  if (fd.get() < 0 || flock(fd.get(), LOCK_EX | LOCK_NB) != 0 || !is_ours(fd.get(), folder)) return;
  remove_tree(folder);
}

void sweep(const fs::path& parent) {
  std::error_code failed;
  std::set<fs::path> found;
  for (fs::directory_iterator i(parent, failed), end; !failed && i != end; i.increment(failed)) {
    if (i->path().filename().native().starts_with(kPrefix)) found.insert(i->path());
  }
  for (const fs::path& folder : found) remove_if_abandoned(folder);
}

[[noreturn]] void fail(const std::string& target, int reason) {
  const bool not_allowed = reason == EACCES || reason == EPERM || reason == EROFS;
  throw Error({target,
               std::string(not_allowed ? "its folder cannot be written to" : "cannot be written") + ": " +
                   std::strerror(reason),
               {},
               {}});
}

}  // namespace

TemporaryFolder::TemporaryFolder(const fs::path& parent, const std::string& target)
    : reserve_(std::make_unique_for_overwrite<std::byte[]>(kReserveBytes)) {
  Registry& all = registry();
  std::unique_lock lock(all.mutex);
  if (all.swept.insert(parent).second) {
    lock.unlock();
    sweep(parent);
    lock.lock();
  }
  // Another process may take the folder for a leftover before it is locked: then a new one is made.
  constexpr int kAttempts = 100;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    std::string name = (parent / (std::string(kPrefix) + "XXXXXX")).string();
    if (mkdtemp(name.data()) == nullptr) fail(target, errno);
    Descriptor fd(name);
    if (const int reason = errno; fd.get() < 0 && reason != ENOENT) {
      rmdir(name.c_str());
      fail(target, reason);
    }
    const bool taken = fd.get() < 0 || (flock(fd.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK);
    std::error_code ignored;
    if (taken || !fs::exists(name, ignored)) continue;
    path_ = name;
    lock_ = fd.release();
    all.folders.insert(path_);
    return;
  }
  fail(target, EBUSY);
}

TemporaryFolder::~TemporaryFolder() {
  close(lock_);      // the one open file that removing needs
  reserve_.reset();  // and the memory
  remove_tree(path_);
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  all.folders.erase(path_);
}

void abandon_temporary_folders() noexcept {
  Registry& all = registry();
  all.mutex.lock();  // for good
  for (const fs::path& folder : all.folders) {
    // Under another name first: what other threads still write has nowhere to go.
    const fs::path gone = folder.string() + "-gone";
    std::error_code ignored;
    fs::rename(folder, gone, ignored);
    // What was on its way in when the name changed, of another thread or of gnuplot, arrives a little later.
    constexpr int kAttempts = 50;
    constexpr auto kPause = std::chrono::milliseconds(5);
    for (int i = 0; i < kAttempts && !remove_tree(gone); ++i) std::this_thread::sleep_for(kPause);
  }
}

}  // namespace scatmap
