#include <fitsio.h>

#include <algorithm>

#include "scatmap/base/error.h"
#include "scatmap/report/fits_file.h"
#include "scatmap/report/fits_sum.h"

namespace scatmap {

struct FitsWriter::Handle {
  fitsfile* file = nullptr;
  int status = 0;
};

namespace {

char* mutable_text(const std::string& text) { return const_cast<char*>(text.c_str()); }  // CFITSIO's C interface

}  // namespace

FitsWriter::FitsWriter(const std::filesystem::path& target, Overwrite overwrite)
    : out_(target, overwrite), fits_(std::make_unique<Handle>()) {
  check(fits_create_diskfile(&fits_->file, out_.temporary().c_str(), &fits_->status), "create it");
}

FitsWriter::~FitsWriter() {
  if (fits_->file == nullptr) return;
  int ignored = 0;
  fits_close_file(fits_->file, &ignored);
}

void FitsWriter::check(int status, const char* doing) {
  if (status == 0) return;
  char text[FLEN_STATUS] = "";
  fits_get_errstatus(status, text);
  fits_clear_errmsg();
  throw Error({out_.target().string(), std::string("cannot ") + doing + ": " + text, {}, {}});
}

void FitsWriter::finish_hdu() {
  if (hdu_open_ && data_sum_) {  // CFITSIO would read all the pixels back
    key("DATASUM", std::to_string(*data_sum_), "data unit checksum");
    key("CHECKSUM", std::string(16, '0'), "HDU checksum");
    check(fits_update_chksum(fits_->file, &fits_->status), "write its checksum");
  } else if (hdu_open_) {
    check(fits_write_chksum(fits_->file, &fits_->status), "write its checksum");
  }
  hdu_open_ = false;
  data_sum_.reset();
}

void FitsWriter::begin_image(const std::string& name, const std::string& unit, int bitpix, int rows, int columns) {
  finish_hdu();
  long axes[2] = {columns, rows};
  check(fits_create_img(fits_->file, bitpix, 2, axes, &fits_->status), "create an image");
  // Keywords come after the pixels: a header that outgrew its blocks would have CFITSIO move them all.
  constexpr int kKeywords = 100;
  check(fits_set_hdrsize(fits_->file, kKeywords, &fits_->status), "create an image");
  hdu_open_ = true;
  key("EXTNAME", name, "name of this image");
  if (!unit.empty()) key("BUNIT", unit, "unit of the pixels");
}

void FitsWriter::image(const std::string& name, const std::string& unit, const Grid<double>& data, FitsPixels pixels) {
  begin_image(name, unit, pixels == FitsPixels::kDouble ? DOUBLE_IMG : FLOAT_IMG, data.rows(), data.columns());
  check(fits_write_img(fits_->file, TDOUBLE, 1, static_cast<LONGLONG>(data.size()), const_cast<double*>(data.data()),
                       &fits_->status),
        "write pixels");
  data_sum_ = pixels == FitsPixels::kDouble ? fits_sum_of_doubles({data.data(), data.size()})
                                            : fits_sum_of_rounded({data.data(), data.size()});
}

void FitsWriter::image(const std::string& name, const std::string& unit, const Grid<float>& data) {
  begin_image(name, unit, FLOAT_IMG, data.rows(), data.columns());
  check(fits_write_img(fits_->file, TFLOAT, 1, static_cast<LONGLONG>(data.size()), const_cast<float*>(data.data()),
                       &fits_->status),
        "write pixels");
  data_sum_ = fits_sum_of_floats({data.data(), data.size()});
}

void FitsWriter::image(const std::string& name, const Grid<Mask>& data) {
  begin_image(name, "", SHORT_IMG, data.rows(), data.columns());
  check(fits_write_img(fits_->file, TUSHORT, 1, static_cast<LONGLONG>(data.size()), const_cast<Mask*>(data.data()),
                       &fits_->status),
        "write pixels");
  data_sum_ = fits_sum_of_masks({data.data(), data.size()});
}

void FitsWriter::table(const std::string& name, const std::vector<FitsColumn>& columns) {
  finish_hdu();
  std::vector<std::string> formats;
  std::size_t rows = 0;
  for (const FitsColumn& c : columns) {
    std::size_t width = 1;
    for (const std::string& t : c.text) width = std::max(width, t.size());
    formats.push_back(c.numbers.empty() ? std::to_string(width) + "A" : "1D");
    rows = std::max(rows, std::max(c.text.size(), c.numbers.size()));
  }
  std::vector<char*> names, forms, units;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    names.push_back(mutable_text(columns[i].name));
    forms.push_back(mutable_text(formats[i]));
    units.push_back(mutable_text(columns[i].unit));
  }
  check(fits_create_tbl(fits_->file, BINARY_TBL, static_cast<LONGLONG>(rows), static_cast<int>(columns.size()),
                        names.data(), forms.data(), units.data(), name.c_str(), &fits_->status),
        "create a table");
  hdu_open_ = true;
  for (std::size_t i = 0; i < columns.size() && rows > 0; ++i) {
    const int column = static_cast<int>(i) + 1;
    if (!columns[i].numbers.empty()) {
      check(fits_write_col(fits_->file, TDOUBLE, column, 1, 1, static_cast<LONGLONG>(rows),
                           const_cast<double*>(columns[i].numbers.data()), &fits_->status),
            "write a column");
      continue;
    }
    std::vector<char*> cells;
    for (const std::string& t : columns[i].text) cells.push_back(mutable_text(t));
    check(fits_write_col(fits_->file, TSTRING, column, 1, 1, static_cast<LONGLONG>(cells.size()), cells.data(),
                         &fits_->status),
          "write a column");
  }
}

void FitsWriter::key(const std::string& name, double value, const std::string& comment) {
  constexpr int kDecimals = 16;  // with the leading digit, 17: every double reads back bit for bit
  check(fits_update_key_dbl(fits_->file, name.c_str(), value, kDecimals, comment.c_str(), &fits_->status),
        "write a keyword");
}

void FitsWriter::key(const std::string& name, int value, const std::string& comment) {
  check(fits_update_key_lng(fits_->file, name.c_str(), value, comment.c_str(), &fits_->status), "write a keyword");
}

void FitsWriter::key(const std::string& name, const std::string& value, const std::string& comment) {
  if (value.size() > 60) check(fits_write_key_longwarn(fits_->file, &fits_->status), "write a keyword");
  check(fits_update_key_longstr(fits_->file, name.c_str(), value.c_str(), comment.c_str(), &fits_->status),
        "write a keyword");
}

void FitsWriter::history(const std::string& text) {
  check(fits_write_history(fits_->file, text.c_str(), &fits_->status), "write HISTORY");
}

void FitsWriter::commit() {
  finish_hdu();
  fitsfile* file = fits_->file;
  fits_->file = nullptr;
  check(fits_close_file(file, &fits_->status), "be written (disk full?)");
  out_.commit();
}

}  // namespace scatmap
