#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scatmap/base/file_state.h"
#include "scatmap/base/grid.h"
#include "scatmap/base/mask.h"
#include "scatmap/base/output_file.h"
#include "scatmap/frame/fits_structure.h"

namespace scatmap {

/// Most rows of a table that is read: an instrument file's lines, causes, frames.
inline constexpr long kMaxFitsTableRows = 1000000;

/// Pixel type on disk.
enum class FitsPixels { kFloat, kDouble };

/// One cell of a table is text or a number.
struct FitsColumn {
  std::string name;
  std::string unit;
  std::vector<std::string> text;  ///< used when `numbers` is empty
  std::vector<double> numbers;
};

/// A FITS file being written, whole or absent (OutputFile). Extension names, units and keywords per HDU; every HDU gets
/// CHECKSUM and DATASUM. CFITSIO makes headers and tables, in memory; pixels go to the disk past it, in parallel.
/// @throws Error naming the target for any failure of CFITSIO or the disk
class FitsWriter {
 public:
  FitsWriter(const std::filesystem::path& target, Overwrite overwrite);
  ~FitsWriter();
  FitsWriter(const FitsWriter&) = delete;
  FitsWriter& operator=(const FitsWriter&) = delete;

  /// Appends an image HDU; the first becomes the primary. The pixels are read when the next HDU begins or at
  /// commit() and must live until then; or move them in.
  /// @param factor multiplies each pixel
  void image(const std::string& name, const std::string& unit, const Grid<double>& data, FitsPixels pixels,
             double factor = 1);
  void image(const std::string& name, const std::string& unit, const Grid<float>& data);
  void image(const std::string& name, const std::string& unit, Grid<float>&& data);
  void image(const std::string& name, const Grid<Mask>& data);
  void image(const std::string& name, const std::string& unit, Grid<double>&& data, FitsPixels pixels,
             double factor = 1) = delete;
  void image(const std::string& name, Grid<Mask>&& data) = delete;
  void table(const std::string& name, const std::vector<FitsColumn>& columns);

  /// Keywords of the HDU begun last. Numbers keep every bit.
  void key(const std::string& name, double value, const std::string& comment);
  void key(const std::string& name, int value, const std::string& comment);
  void key(const std::string& name, const std::string& value, const std::string& comment);
  void history(const std::string& text);

  void commit();

 private:
  void check(int status, const char* doing);
  void begin_hdu();
  void begin_image(const std::string& name, const std::string& unit, int bitpix, int rows, int columns);
  void finish_hdu();

  OutputFile out_;
  struct State;
  std::unique_ptr<State> state_;
};

/// A FITS file being read back; each HDU that is used is held to its DATASUM and CHECKSUM.
/// @throws Error naming file and HDU
class FitsReader {
 public:
  explicit FitsReader(const std::filesystem::path& path);
  ~FitsReader();
  FitsReader(const FitsReader&) = delete;
  FitsReader& operator=(const FitsReader&) = delete;

  bool has(const std::string& hdu_name);
  /// Extension names in file order.
  std::vector<std::string> names() const { return names_; }
  /// To be called when all is read. @throws Error if the file changed meanwhile
  void require_unchanged() const { scatmap::require_unchanged(path_, state_); }
  Grid<double> image_double(const std::string& hdu_name);
  Grid<float> image_float(const std::string& hdu_name);
  Grid<Mask> image_mask(const std::string& hdu_name);
  std::vector<std::string> text_column(const std::string& hdu_name, const std::string& column);
  std::vector<double> number_column(const std::string& hdu_name, const std::string& column);
  std::optional<double> number_key(const std::string& hdu_name, const std::string& key);
  std::optional<std::string> text_key(const std::string& hdu_name, const std::string& key);

 private:
  void select(const std::string& hdu_name);
  void check(int status, const std::string& doing);
  template <class T>
  Grid<T> image(const std::string& hdu_name, int type);
  int column_number(const std::string& hdu_name, const std::string& column);
  long row_count(const std::string& hdu_name);

  std::filesystem::path path_;
  FileState state_;
  struct Handle;
  std::unique_ptr<Handle> fits_;
  std::vector<FitsHdu> hdus_;
  std::vector<std::string> names_;
  std::vector<bool> summed_;  // held to its sums
};

}  // namespace scatmap
