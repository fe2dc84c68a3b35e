#include <fitsio.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

#include "scatmap/base/error.h"
#include "scatmap/frame/fits_checksum.h"
#include "scatmap/frame/frame.h"
#include "scatmap/report/fits_file.h"

namespace scatmap {

struct FitsReader::Handle {
  fitsfile* file = nullptr;
  int status = 0;
};

namespace {

// A map's other format, written for viewing.
void refuse_exr(const std::filesystem::path& path) {
  std::array<char, 4> begin{};
  std::ifstream stream(path, std::ios::binary);
  if (stream.read(begin.data(), begin.size()) && std::string_view(begin.data(), begin.size()) == "v/1\x01")
    throw Error({path.string(), "is an OpenEXR image: give the FITS map", {}, {}});
}

}  // namespace

FitsReader::FitsReader(const std::filesystem::path& path) : path_(path), fits_(std::make_unique<Handle>()) {
  if (std::filesystem::is_regular_file(path)) refuse_exr(path);
  require_fits_file(path);
  state_ = file_state(path);
  hdus_ = check_fits_structure(path);
  for (const FitsHdu& hdu : hdus_) names_.push_back(hdu.header.text("EXTNAME").value_or(hdu.name));
  summed_.resize(hdus_.size());
  // Absolute: CFITSIO drops leading blanks and expands a leading tilde, even of files on disk.
  check(fits_open_diskfile(&fits_->file, std::filesystem::absolute(path).c_str(), READONLY, &fits_->status), "open it");
}

FitsReader::~FitsReader() {
  if (fits_->file == nullptr) return;
  int ignored = 0;
  fits_close_file(fits_->file, &ignored);
}

void FitsReader::check(int status, const std::string& doing) {
  if (status == 0) return;
  char text[FLEN_STATUS] = "";
  fits_get_errstatus(status, text);
  fits_clear_errmsg();
  fits_->status = 0;
  throw Error({path_.string(), "cannot " + doing + ": " + text, {}, {}});
}

bool FitsReader::has(const std::string& hdu_name) {
  return std::find(names_.begin(), names_.end(), hdu_name) != names_.end();
}

void FitsReader::select(const std::string& hdu_name) {
  const auto found = std::find(names_.begin(), names_.end(), hdu_name);
  if (found == names_.end())
    throw Error({path_.string(), "has no HDU " + hdu_name, {}, "a BRDF map as scatmap writes it"});
  const auto index = static_cast<std::size_t>(found - names_.begin());
  if (!summed_[index]) require_fits_sums(path_, hdus_[index]);
  summed_[index] = true;
  check(fits_movabs_hdu(fits_->file, static_cast<int>(index) + 1, nullptr, &fits_->status), "go to HDU " + hdu_name);
}

template <class T>
Grid<T> FitsReader::image(const std::string& hdu_name, int type) {
  select(hdu_name);
  int axes = 0;
  long sizes[2] = {0, 0};
  check(fits_get_img_dim(fits_->file, &axes, &fits_->status), "read the size of " + hdu_name);
  if (axes != 2)
    throw Error({path_.string() + ": " + hdu_name, "is no image", std::to_string(axes) + " axes", "2 axes"});
  check(fits_get_img_size(fits_->file, 2, sizes, &fits_->status), "read the size of " + hdu_name);
  constexpr long kMaxSide = 32768;
  if (sizes[0] < 1 || sizes[1] < 1 || sizes[0] > kMaxSide || sizes[1] > kMaxSide) {
    throw Error({path_.string() + ": " + hdu_name,
                 "has an impossible size",
                 std::to_string(sizes[0]) + " x " + std::to_string(sizes[1]),
                 {}});
  }
  Grid<T> out(static_cast<int>(sizes[1]), static_cast<int>(sizes[0]));
  check(fits_read_img(fits_->file, type, 1, static_cast<LONGLONG>(out.size()), nullptr, out.data(), nullptr,
                      &fits_->status),
        "read " + hdu_name);
  return out;
}

Grid<double> FitsReader::image_double(const std::string& hdu_name) { return image<double>(hdu_name, TDOUBLE); }
Grid<float> FitsReader::image_float(const std::string& hdu_name) { return image<float>(hdu_name, TFLOAT); }
Grid<Mask> FitsReader::image_mask(const std::string& hdu_name) { return image<Mask>(hdu_name, TUSHORT); }

int FitsReader::column_number(const std::string& hdu_name, const std::string& column) {
  select(hdu_name);
  int number = 0;
  std::string name = column;
  check(fits_get_colnum(fits_->file, CASEINSEN, name.data(), &number, &fits_->status),
        "find column " + column + " of " + hdu_name);
  return number;
}

long FitsReader::row_count(const std::string& hdu_name) {
  long rows = 0;
  check(fits_get_num_rows(fits_->file, &rows, &fits_->status), "count the rows of " + hdu_name);
  if (rows > kMaxFitsTableRows) {
    throw Error({path_.string() + ": " + hdu_name, "has too many rows", std::to_string(rows),
                 "at most " + std::to_string(kMaxFitsTableRows)});
  }
  return rows;
}

std::vector<std::string> FitsReader::text_column(const std::string& hdu_name, const std::string& column) {
  const int number = column_number(hdu_name, column);
  int type = 0;
  long repeat = 0, width = 0;
  check(fits_get_coltype(fits_->file, number, &type, &repeat, &width, &fits_->status), "read column " + column);
  if (type != TSTRING || repeat < 0 || repeat > 100000)
    throw Error({path_.string() + ": " + hdu_name, "column " + column + " is no text", {}, {}});
  std::vector<std::string> out;
  std::string cell;
  for (long row = 1, rows = row_count(hdu_name); row <= rows; ++row) {
    cell.assign(static_cast<std::size_t>(repeat) + 1, '\0');
    char* data = cell.data();
    check(fits_read_col(fits_->file, TSTRING, number, row, 1, 1, nullptr, &data, nullptr, &fits_->status),
          "read column " + column);
    out.emplace_back(cell.c_str());
  }
  return out;
}

std::vector<double> FitsReader::number_column(const std::string& hdu_name, const std::string& column) {
  const int number = column_number(hdu_name, column);
  std::vector<double> out(static_cast<std::size_t>(row_count(hdu_name)));
  if (out.empty()) return out;
  check(fits_read_col(fits_->file, TDOUBLE, number, 1, 1, static_cast<LONGLONG>(out.size()), nullptr, out.data(),
                      nullptr, &fits_->status),
        "read column " + column);
  return out;
}

std::optional<double> FitsReader::number_key(const std::string& hdu_name, const std::string& key) {
  select(hdu_name);
  double value = 0;
  const int status = fits_read_key(fits_->file, TDOUBLE, key.c_str(), &value, nullptr, &fits_->status);
  if (status == KEY_NO_EXIST) {
    fits_->status = 0;
    fits_clear_errmsg();
    return std::nullopt;
  }
  check(status, "read keyword " + key);
  return value;
}

std::optional<std::string> FitsReader::text_key(const std::string& hdu_name, const std::string& key) {
  select(hdu_name);
  char* value = nullptr;
  const int status = fits_read_key_longstr(fits_->file, key.c_str(), &value, nullptr, &fits_->status);
  if (status == KEY_NO_EXIST) {
    fits_->status = 0;
    fits_clear_errmsg();
    return std::nullopt;
  }
  check(status, "read keyword " + key);
  std::string out = value;
  int ignored = 0;
  fits_free_memory(value, &ignored);
  return out;
}

}  // namespace scatmap
