#include "scatmap/base/output_folder.h"

#include <fcntl.h>

#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <set>
#include <sstream>
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

fs::path parent_of(const fs::path& target) {
  if (target.filename().native().size() > NAME_MAX) throw Error({target.string(), "has too long a name", {}, {}});
  std::error_code ignored;
  if (fs::is_directory(target.parent_path(), ignored)) return target.parent_path();
  throw Error({target.string(), "its folder does not exist", {}, {}});
}

bool is_empty_folder(const fs::path& path) { return fs::is_directory(path) && fs::is_empty(path); }

std::set<std::string> files_below(const fs::path& folder) {
  std::set<std::string> out;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_directory() || entry.is_symlink()) out.insert(entry.path().lexically_relative(folder).string());
  }
  return out;
}

// Line breaks may be part of a name that somebody gave; none of ours has any.
std::string contents_of(const fs::path& folder) {
  std::string text;
  for (const std::string& file : files_below(folder)) text += file + "\n";
  return text;
}

// Folders of before the list was kept have none.
void refuse_foreign_files(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::exists(folder / kContents, ignored)) return;
  std::set<std::string> ours{kContents};
  std::istringstream lines(read_text_file(folder / kContents));
  for (std::string line; std::getline(lines, line);) ours.insert(line);
  for (const std::string& file : files_below(folder)) {
    if (!ours.contains(file))
      throw Error({(folder / file).string(),
                   "was not written by scatmap; even --force does not remove it",
                   {},
                   "a folder with scatmap's own files, or another name"});
  }
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& target, fs::path marker, Overwrite overwrite)
    : target_(without_trailing_slash(target)),
      marker_(std::move(marker)),
      overwrite_(overwrite),
      folder_((refuse_existing(), parent_of(target_)), target_.string()),
      temporary_(folder_.path() / "new") {
  std::error_code failed;
  fs::create_directory(temporary_, failed);
  if (failed) throw Error({target_.string(), "cannot be made: " + failed.message(), {}, {}});
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
  refuse_foreign_files(target_);
}

void OutputFolder::commit() {
  write_text_file(temporary_ / kContents, contents_of(temporary_), Overwrite::kKeep);
  refuse_existing();
  if (!fs::exists(target_) || is_empty_folder(target_)) {
    rename_whole(temporary_, target_, Overwrite::kKeep);
    return;
  }
  // The old folder then goes with the temporary one.
  if (renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0) return;
  if (errno != EINVAL && errno != ENOSYS) {
    throw Error({target_.string(), std::string("cannot be written: ") + std::strerror(errno), {}, {}});
  }
  // File systems that cannot exchange: for a moment there is no folder under the name.
  const fs::path old = target_.parent_path() / ("." + target_.filename().string() + ".scatmap-replaced");
  rename_whole(target_, old, Overwrite::kForce);
  try {
    rename_whole(temporary_, target_, Overwrite::kForce);
  } catch (const Error&) {
    rename_whole(old, target_, Overwrite::kForce);
    throw;
  }
  std::error_code ignored;
  fs::remove_all(old, ignored);
}

}  // namespace scatmap
