#include "scatmap/base/output_folder.h"

#include <unistd.h>

#include <atomic>
#include <string>
#include <system_error>
#include <utility>

#include "scatmap/base/error.h"

namespace scatmap {
namespace fs = std::filesystem;
namespace {

// "dir/", "dir/." and "dir" are one folder; a rename needs its own name.
fs::path without_trailing_slash(const fs::path& path) {
  const fs::path whole = fs::absolute(path).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

fs::path hidden_sibling(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  std::string name = ".";
  name += target.filename().string() + ".scatmap-" + std::to_string(getpid()) + "-" + std::to_string(counter++);
  return target.parent_path() / name;
}

void rename_or_throw(const fs::path& from, const fs::path& to, const fs::path& target) {
  std::error_code failed;
  fs::rename(from, to, failed);
  if (failed) throw Error({target.string(), "cannot be written: " + failed.message(), {}, {}});
}

bool is_empty_folder(const fs::path& path) { return fs::is_directory(path) && fs::is_empty(path); }

}  // namespace

OutputFolder::OutputFolder(const fs::path& target, fs::path marker, Overwrite overwrite)
    : target_(without_trailing_slash(target)),
      marker_(std::move(marker)),
      temporary_(hidden_sibling(target_)),
      overwrite_(overwrite) {
  refuse_existing();
  std::error_code failed;
  fs::create_directory(temporary_, failed);
  if (failed) throw Error({target_.string(), "cannot be made: " + failed.message(), {}, {}});
}

OutputFolder::~OutputFolder() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
}

void OutputFolder::refuse_existing() const {
  std::error_code ignored;
  const fs::file_status status = fs::symlink_status(target_, ignored);
  if (!fs::exists(status)) return;
  if (!fs::is_directory(status)) throw Error({target_.string(), "exists and is not a folder", {}, "a folder to write"});
  if (is_empty_folder(target_)) return;
  if (overwrite_ == Overwrite::kKeep) {
    throw Error({target_.string(), "exists and is kept; use --force to replace it", {}, {}});
  }
  if (!fs::exists(target_ / marker_, ignored)) {
    throw Error({target_.string(),
                 "holds no " + marker_.string() + ", so it is not ours to replace, even with --force",
                 {},
                 {}});
  }
}

void OutputFolder::commit() {
  refuse_existing();
  if (fs::exists(target_) && !is_empty_folder(target_)) {
    const fs::path old = hidden_sibling(target_);
    rename_or_throw(target_, old, target_);
    std::error_code failed;
    fs::rename(temporary_, target_, failed);
    if (failed) {
      rename_or_throw(old, target_, target_);
      throw Error({target_.string(), "cannot be written: " + failed.message(), {}, {}});
    }
    fs::remove_all(old, failed);
  } else {
    rename_or_throw(temporary_, target_, target_);
  }
  committed_ = true;
}

}  // namespace scatmap
