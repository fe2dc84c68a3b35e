#include <fitsio.h>

#include <algorithm>
#include <cstdlib>
#include <new>

#include "scatmap/base/error.h"
#include "scatmap/frame/fits_sum.h"
#include "scatmap/report/fits_file.h"
#include "scatmap/report/fits_image_data.h"

namespace scatmap {
namespace {

char* mutable_text(const std::string& text) { return const_cast<char*>(text.c_str()); }  // CFITSIO's C interface

constexpr std::size_t kCard = 80;

// Places `text` from `column` on into the card of that keyword. @pre the card exists
void patch(std::string& header, const char* keyword, std::size_t column, const std::string& text) {
  for (std::size_t at = 0; at < header.size(); at += kCard) {
    if (header.compare(at, 8, keyword) == 0) {
      header.replace(at + column, text.size(), text);
      return;
    }
  }
}

constexpr std::size_t kStringColumn = 11, kNumberColumn = 10, kNumberWidth = 20;

std::string padded(const std::string& text, std::size_t width, bool to_the_right) {
  const std::string blanks(width - text.size(), ' ');
  return to_the_right ? blanks + text : text + blanks;
}

// Keywords that are known only when the data are written.
const std::string kNoDataSum(10, '0'), kNoCheckSum(16, '0');

}  // namespace

// The HDU in hand is made in memory, behind an empty primary unless it is the first.
struct FitsWriter::State {
  PositionedFile disk;
  std::int64_t at = 0;  // where the HDU in hand will begin
  fitsfile* file = nullptr;
  void* memory = nullptr;
  std::size_t bytes = 0;
  int status = 0;
  std::optional<FitsImageData> image{};  // absent: a table
  int rows = 0;                          // of the image
  Grid<float> kept{};                    // pixels that nobody else keeps

  void drop() {
    int ignored = 0;
    if (file != nullptr) fits_close_file(file, &ignored);
    fits_clear_errmsg();
    std::free(memory);
    file = nullptr;
    memory = nullptr;
    image.reset();
    kept = {};
  }
  ~State() { drop(); }
};

FitsWriter::FitsWriter(const std::filesystem::path& target, Overwrite overwrite)
    : out_(target, overwrite), state_(new State{{out_.temporary(), out_.target().string()}}) {}

FitsWriter::~FitsWriter() = default;

void FitsWriter::check(int status, const char* doing) {
  if (status == 0) return;
  char text[FLEN_STATUS] = "";
  fits_get_errstatus(status, text);
  fits_clear_errmsg();
  throw Error({out_.target().string(), std::string("cannot ") + doing + ": " + text, {}, {}});
}

void FitsWriter::finish_hdu() {
  State& s = *state_;
  if (s.file == nullptr) return;
  if (s.image) {
    key("DATASUM", kNoDataSum, "data unit checksum");
    key("CHECKSUM", kNoCheckSum, "HDU checksum");
  } else {
    check(fits_write_chksum(s.file, &s.status), "write its checksum");
  }
  check(fits_flush_file(s.file, &s.status), "make a header");
  LONGLONG begin = 0, data = 0, end = 0;
  check(fits_get_hduaddrll(s.file, &begin, &data, &end, &s.status), "make a header");
  const char* hdu = static_cast<const char*>(s.memory) + begin;
  std::string header(hdu, static_cast<std::size_t>((s.image ? data : end) - begin));
  const auto size = static_cast<std::int64_t>(header.size());
  std::int64_t data_size = 0;
  if (s.image) {
    const std::uint32_t sum = write_image_data(*s.image, s.disk, s.at + size);
    data_size = (s.image->bytes() + 2879) / 2880 * 2880;
    patch(header, "NAXIS2  ", kNumberColumn, padded(std::to_string(s.rows), kNumberWidth, true));
    patch(header, "DATASUM ", kStringColumn, padded(std::to_string(sum), kNoDataSum.size(), false));
    char text[17] = "";
    fits_encode_chksum(fits_sum_folded(std::uint64_t{fits_sum_of_bytes(header)} + sum), 1, text);
    patch(header, "CHECKSUM", kStringColumn, text);
  }
  s.disk.write(header.data(), header.size(), s.at);
  s.at += size + data_size;
  s.drop();
}

void FitsWriter::begin_hdu() {
  finish_hdu();
  State& s = *state_;
  constexpr std::size_t kFirst = 64 * 2880;
  s.bytes = kFirst;
  s.memory = std::calloc(s.bytes, 1);  // zeros: CFITSIO looks for the end of a header that it has yet to write
  if (s.memory == nullptr) throw std::bad_alloc();
  check(fits_create_memfile(&s.file, &s.memory, &s.bytes, kFirst, std::realloc, &s.status), "make a header");
  if (s.at > 0) check(fits_create_img(s.file, BYTE_IMG, 0, nullptr, &s.status), "make a header");
}

void FitsWriter::begin_image(const std::string& name, const std::string& unit, int bitpix, int rows, int columns) {
  begin_hdu();
  State& s = *state_;
  s.rows = rows;
  long axes[2] = {columns, 0};  // the rows are not in memory
  check(fits_create_img(s.file, bitpix, 2, axes, &s.status), "create an image");
  key("EXTNAME", name, "name of this image");
  if (!unit.empty()) key("BUNIT", unit, "unit of the pixels");
}

void FitsWriter::image(const std::string& name, const std::string& unit, const Grid<double>& data, FitsPixels pixels,
                       double factor) {
  begin_image(name, unit, pixels == FitsPixels::kDouble ? DOUBLE_IMG : FLOAT_IMG, data.rows(), data.columns());
  state_->image = FitsImageData{&data, pixels, factor};
}

void FitsWriter::image(const std::string& name, const std::string& unit, const Grid<float>& data) {
  begin_image(name, unit, FLOAT_IMG, data.rows(), data.columns());
  state_->image = FitsImageData{&data};
}

void FitsWriter::image(const std::string& name, const std::string& unit, Grid<float>&& data) {
  begin_image(name, unit, FLOAT_IMG, data.rows(), data.columns());
  state_->kept = std::move(data);
  state_->image = FitsImageData{&state_->kept};
}

void FitsWriter::image(const std::string& name, const Grid<Mask>& data) {
  begin_image(name, "", SHORT_IMG, data.rows(), data.columns());
  state_->image = FitsImageData{&data};
}

void FitsWriter::table(const std::string& name, const std::vector<FitsColumn>& columns) {
  begin_hdu();
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
  check(fits_create_tbl(state_->file, BINARY_TBL, static_cast<LONGLONG>(rows), static_cast<int>(columns.size()),
                        names.data(), forms.data(), units.data(), name.c_str(), &state_->status),
        "create a table");
  for (std::size_t i = 0; i < columns.size() && rows > 0; ++i) {
    const int column = static_cast<int>(i) + 1;
    if (!columns[i].numbers.empty()) {
      check(fits_write_col(state_->file, TDOUBLE, column, 1, 1, static_cast<LONGLONG>(rows),
                           const_cast<double*>(columns[i].numbers.data()), &state_->status),
            "write a column");
      continue;
    }
    std::vector<char*> cells;
    for (const std::string& t : columns[i].text) cells.push_back(mutable_text(t));
    check(fits_write_col(state_->file, TSTRING, column, 1, 1, static_cast<LONGLONG>(cells.size()), cells.data(),
                         &state_->status),
          "write a column");
  }
}

void FitsWriter::key(const std::string& name, double value, const std::string& comment) {
  constexpr int kDecimals = 16;  // with the leading digit, 17: every double reads back bit for bit
  check(fits_update_key_dbl(state_->file, name.c_str(), value, kDecimals, comment.c_str(), &state_->status),
        "write a keyword");
}

void FitsWriter::key(const std::string& name, int value, const std::string& comment) {
  check(fits_update_key_lng(state_->file, name.c_str(), value, comment.c_str(), &state_->status), "write a keyword");
}

void FitsWriter::key(const std::string& name, const std::string& value, const std::string& comment) {
  if (value.size() > 60) check(fits_write_key_longwarn(state_->file, &state_->status), "write a keyword");
  check(fits_update_key_longstr(state_->file, name.c_str(), value.c_str(), comment.c_str(), &state_->status),
        "write a keyword");
}

void FitsWriter::history(const std::string& text) {
  std::string printable = text;  // names of files need not be, cards must
  for (char& c : printable) c = c < 0x20 || c > 0x7e ? '?' : c;
  check(fits_write_history(state_->file, printable.c_str(), &state_->status), "write HISTORY");
}

void FitsWriter::commit() {
  finish_hdu();
  state_->disk.close();
  out_.commit();
}

}  // namespace scatmap
