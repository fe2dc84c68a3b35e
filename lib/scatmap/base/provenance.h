#pragma once
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scatmap/base/file_state.h"

namespace scatmap {

/// The version of the library, "0.1.0".
std::string version();

/// An input as it was when it was read.
struct InputRecord {
  std::string path;    ///< as the user named it; utf8_text
  std::string sha256;  ///< 64 lower-case hexadecimal digits
};

/// What every output records, so that it can be made again.
struct Provenance {
  std::string command_line;
  std::string written_by = "scatmap " + version();
  std::vector<InputRecord> inputs;
};

/// The text with every byte that is not part of well-formed UTF-8 as '?': file names may be any bytes, TOML and JSON may not.
std::string utf8_text(const std::string& bytes);

/// SHA-256 of a file's bytes as they are read, so that what is recorded is what was used and the file is read once.
class InputHash {
 public:
  InputHash();
  ~InputHash();
  InputHash(const InputHash&) = delete;
  InputHash& operator=(const InputHash&) = delete;
  void add(std::span<const unsigned char> bytes);
  /// Ends the sum.
  InputRecord record(const std::filesystem::path& path);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// SHA-256 (FIPS 180-4) of a file's bytes. @throws Error if it cannot be read or changes meanwhile
InputRecord record_input(const std::filesystem::path& path);
/// The same for a file that was read before. @throws Error also if it is not as it was then
InputRecord record_input(const std::filesystem::path& path, const FileState& as_read);

}  // namespace scatmap
