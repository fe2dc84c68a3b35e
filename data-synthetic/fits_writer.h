#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "scatmap/base/grid.h"

namespace scatmap::synth {

struct FitsCard {
  std::string keyword;  ///< "HISTORY" and "COMMENT" take text of any length
  std::variant<double, std::string> value;
  std::string comment;
};

/// A FITS file in the making, through CFITSIO's disk-only call: the name is taken as it is, never as an expression.
class FitsWriter {
 public:
  /// @throws Error if the file exists or cannot be made
  explicit FitsWriter(std::filesystem::path path);
  ~FitsWriter();
  FitsWriter(const FitsWriter&) = delete;
  FitsWriter& operator=(const FitsWriter&) = delete;

  /// Adds an image HDU; the first is the primary. Row 0 is stored first. @throws Error
  void image(const Grid<std::uint16_t>& dn, const std::vector<FitsCard>& cards);
  void image(const Grid<double>& values, const std::vector<FitsCard>& cards);
  /// @throws Error, a full disk say
  void close();

 private:
  void create(int bitpix, int rows, int columns, const std::vector<FitsCard>& cards);
  void check(int status) const;

  std::filesystem::path path_;
  void* file_ = nullptr;  // fitsfile
};

}  // namespace scatmap::synth
