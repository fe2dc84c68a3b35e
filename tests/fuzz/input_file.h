#pragma once
#include <fcntl.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "scatmap/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fuzz {

/// A file of this process's own, in memory, for readers that take a path. Its folder goes when the process ends.
class InputFile {
 public:
  explicit InputFile(const char* name) {
    std::string folder = "/dev/shm/scatmap-fuzz-XXXXXX";
    if (mkdtemp(folder.data()) == nullptr) std::abort();
    folder_ = folder;
    path_ = folder_ / name;
  }
  ~InputFile() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Another file in the same folder.
  void beside(const char* name, const std::string& text) const { put(folder_ / name, text.data(), text.size()); }
  void fill(const std::uint8_t* data, std::size_t size) const { put(path_, data, size); }

 private:
  static void put(const std::filesystem::path& path, const void* data, std::size_t size) {
    const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0 || write(fd, data, size) != static_cast<ssize_t>(size)) std::abort();
    close(fd);
  }
  std::filesystem::path folder_, path_;
};

/// Runs a reader. scatmap::Error is the one way in which it may refuse; any other exception ends the process.
template <class Read>
int run(Read read) {
  try {
    read();
  } catch (const scatmap::Error&) {
  }
  return 0;
}

/// The input as a file under `name`, given to `read(path)`.
template <class Read>
int run_file(const char* name, const std::uint8_t* data, std::size_t size, Read read) {
  static const InputFile kFile(name);
  kFile.fill(data, size);
  return run([&] { read(kFile.path()); });
}

/// The input as text, given to `parse(text)`.
template <class Parse>
int run_text(const std::uint8_t* data, std::size_t size, Parse parse) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  return run([&] { parse(text); });
}

}  // namespace fuzz
