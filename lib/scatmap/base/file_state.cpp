#include "scatmap/base/file_state.h"

#include <cerrno>
#include <cstring>

#include "scatmap/base/error.h"

namespace scatmap {
namespace {

bool same(const timespec& a, const timespec& b) { return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec; }

}  // namespace

bool FileState::operator==(const FileState& other) const {
  return device == other.device && inode == other.inode && bytes == other.bytes && same(written, other.written) &&
         same(changed, other.changed);
}

FileState file_state(const std::filesystem::path& path) {
  struct stat s {};
  if (stat(path.c_str(), &s) != 0)
    throw Error({path.string(), std::string("cannot be read: ") + std::strerror(errno), {}, {}});
  return {s.st_dev, s.st_ino, s.st_size, s.st_mtim, s.st_ctim};
}

void require_unchanged(const std::filesystem::path& path, const FileState& before) {
  if (!(file_state(path) == before)) throw Error({path.string(), "changed while it was read", {}, "a finished file"});
}

}  // namespace scatmap
