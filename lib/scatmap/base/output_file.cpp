#include "scatmap/base/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include "scatmap/base/error.h"

namespace scatmap {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const fs::path& target, int reason) {
  throw Error({target.string(), std::string("cannot be written: ") + std::strerror(reason), {}, {}});
}

[[noreturn]] void fail_existing(const fs::path& target) {
  throw Error({target.string(), "exists and is kept; use --force to replace it", {}, {}});
}

void refuse_existing(const fs::path& target, Overwrite overwrite) {
  std::error_code ignored;
  if (fs::is_directory(target, ignored)) throw Error({target.string(), "is a folder", {}, "a file to write"});
  if (overwrite == Overwrite::kKeep && fs::exists(fs::symlink_status(target, ignored))) {
    fail_existing(target);
  }
}

// The target's folder, once everything is known that would keep the target from being written.
fs::path checked_folder(const fs::path& target, Overwrite overwrite) {
  if (target.filename().empty()) throw Error({target.string(), "names no file to write", {}, {}});
  if (target.filename().native().size() > NAME_MAX) throw Error({target.string(), "has too long a name", {}, {}});
  refuse_existing(target, overwrite);
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) throw Error({target.string(), "its folder does not exist", {}, {}});
  return folder;
}

void flush_to_disk(const fs::path& path, const fs::path& target) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool ok = fd >= 0 && fsync(fd) == 0;
  const int reason = errno;
  if (fd >= 0) close(fd);
  if (!ok) fail(target, reason);
}

void write_all(const fs::path& path, std::string_view text, const fs::path& target) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  int reason = fd < 0 ? errno : 0;
  while (reason == 0 && !text.empty()) {
    const ssize_t n = write(fd, text.data(), text.size());
    if (n >= 0) {
      text.remove_prefix(static_cast<std::size_t>(n));
    } else if (errno != EINTR) {
      reason = errno;
    }
  }
  if (fd >= 0 && close(fd) != 0 && reason == 0) reason = errno;
  if (reason != 0) fail(target, reason);
}

}  // namespace

OutputFile::OutputFile(fs::path target, Overwrite overwrite)
    : target_(std::move(target)),
      overwrite_(overwrite),
      folder_(checked_folder(target_, overwrite_), target_.string()),
      temporary_(folder_.path() / target_.filename()) {}

void OutputFile::commit() {
  refuse_existing(target_, overwrite_);
  flush_to_disk(temporary_, target_);
  rename_whole(temporary_, target_, overwrite_);
}

void rename_whole(const fs::path& from, const fs::path& to, Overwrite overwrite) {
  if (overwrite == Overwrite::kKeep && !fs::is_directory(from)) {
    // Between the check and the rename another process may have written the target.
    if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return;
    if (errno == EEXIST) fail_existing(to);
    if (errno != EINVAL && errno != ENOSYS) fail(to, errno);  // what file systems without it say
  }
  if (rename(from.c_str(), to.c_str()) == 0) return;
  if (errno == EEXIST || errno == ENOTEMPTY) fail_existing(to);
  fail(to, errno);
}

void write_text_file(const fs::path& target, std::string_view text, Overwrite overwrite) {
  OutputFile out(target, overwrite);
  write_all(out.temporary(), text, target);
  out.commit();
}

std::string read_text_file(const fs::path& path, std::size_t limit_bytes) {
  std::error_code failed;
  if (!fs::exists(path, failed)) throw Error({path.string(), "no such file", {}, {}});
  if (!fs::is_regular_file(path, failed)) throw Error({path.string(), "is not a regular file", {}, {}});
  const auto size = fs::file_size(path, failed);
  if (failed) throw Error({path.string(), "cannot be read: " + failed.message(), {}, {}});
  if (size > limit_bytes) {
    throw Error({path.string(), "is too large", std::to_string(size) + " bytes",
                 "at most " + std::to_string(limit_bytes) + " bytes"});
  }
  std::ifstream stream(path, std::ios::binary);
  std::string text(size, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(size));
  if (!stream) throw Error({path.string(), "cannot be read", {}, {}});
  return text;
}

}  // namespace scatmap
