#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>

#include "scatmap/base/grid.h"
#include "scatmap/base/mask.h"
#include "scatmap/report/fits_file.h"

namespace scatmap {

/// A file written at positions, several threads at a time. @throws Error naming the target
class PositionedFile {
 public:
  PositionedFile(const std::filesystem::path& path, std::string target);
  ~PositionedFile();
  PositionedFile(const PositionedFile&) = delete;
  PositionedFile& operator=(const PositionedFile&) = delete;
  void write(const void* bytes, std::size_t count, std::int64_t at) const;
  /// What was written there is on its way to the disk while more is made, so that flushing at the end waits less.
  void begin_to_store(std::int64_t at, std::int64_t count) const;
  /// @throws Error for what the disk has held back until now
  void close();

 private:
  [[noreturn]] void fail() const;
  std::string target_;
  int descriptor_;
};

/// The pixels of an image, somewhere in memory, and how they are stored.
struct FitsImageData {
  std::variant<const Grid<double>*, const Grid<float>*, const Grid<Mask>*> pixels;
  FitsPixels stored = FitsPixels::kFloat;  ///< doubles only
  double factor = 1;                       ///< doubles only: multiplies each

  std::int64_t bytes() const;
};

/// Writes the data unit, padded, at `at`. @return its DATASUM
std::uint32_t write_image_data(const FitsImageData& data, const PositionedFile& file, std::int64_t at);

}  // namespace scatmap
