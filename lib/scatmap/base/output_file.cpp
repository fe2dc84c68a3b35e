#include "scatmap/base/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include "scatmap/base/error.h"

namespace scatmap {
namespace fs = std::filesystem;
namespace {

std::string temporary_name(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  return "." + target.stem().string() + ".scatmap-" + std::to_string(getpid()) + "-" + std::to_string(counter++) +
         target.extension().string();
}

void refuse_existing(const fs::path& target, Overwrite overwrite) {
  std::error_code ignored;
  if (fs::is_directory(target, ignored)) throw Error({target.string(), "is a folder", {}, "a file to write"});
  if (overwrite == Overwrite::kKeep && fs::exists(fs::symlink_status(target, ignored))) {
    throw Error({target.string(), "exists and is kept; use --force to replace it", {}, {}});
  }
}

void flush_to_disk(const fs::path& path, const fs::path& target) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool ok = fd >= 0 && fsync(fd) == 0;
  const int reason = errno;
  if (fd >= 0) close(fd);
  if (!ok) throw Error({target.string(), std::string("cannot be written: ") + std::strerror(reason), {}, {}});
}

}  // namespace

OutputFile::OutputFile(fs::path target, Overwrite overwrite) : target_(std::move(target)), overwrite_(overwrite) {
  if (target_.filename().empty()) throw Error({target_.string(), "names no file to write", {}, {}});
  refuse_existing(target_, overwrite_);
  const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) throw Error({target_.string(), "its folder does not exist", {}, {}});
  if (access(folder.c_str(), W_OK) != 0) throw Error({target_.string(), "its folder cannot be written to", {}, {}});
  temporary_ = folder / temporary_name(target_);
}

OutputFile::~OutputFile() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

void OutputFile::commit() {
  refuse_existing(target_, overwrite_);
  flush_to_disk(temporary_, target_);
  std::error_code failed;
  fs::rename(temporary_, target_, failed);
  if (failed) throw Error({target_.string(), "cannot be written: " + failed.message(), {}, {}});
  committed_ = true;
}

void write_text_file(const fs::path& target, std::string_view text, Overwrite overwrite) {
  OutputFile out(target, overwrite);
  {
    std::ofstream stream(out.temporary(), std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.close();
    if (!stream) throw Error({target.string(), "cannot be written (disk full?)", {}, {}});
  }
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
