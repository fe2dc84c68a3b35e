#include "data-synthetic/fits_writer.h"

#include <fitsio.h>

#include <array>
#include <utility>

#include "scatmap/base/error.h"

namespace scatmap::synth {
namespace {

fitsfile* handle(void* file) { return static_cast<fitsfile*>(file); }

void write_card(fitsfile* file, const FitsCard& card, int& status) {
  const char* comment = card.comment.c_str();
  if (const auto* number = std::get_if<double>(&card.value)) {
    fits_update_key_dbl(file, card.keyword.c_str(), *number, -17, comment, &status);
    return;
  }
  const std::string& text = std::get<std::string>(card.value);
  if (card.keyword == "HISTORY") {
    fits_write_history(file, text.c_str(), &status);
  } else {
    fits_update_key_str(file, card.keyword.c_str(), text.c_str(), comment, &status);
  }
}

}  // namespace

FitsWriter::FitsWriter(std::filesystem::path path) : path_(std::move(path)) {
  int status = 0;
  fitsfile* file = nullptr;
  fits_create_diskfile(&file, path_.c_str(), &status);
  file_ = file;
  check(status);
}

FitsWriter::~FitsWriter() {
  int status = 0;
  if (file_ != nullptr) fits_close_file(handle(file_), &status);
}

void FitsWriter::check(int status) const {
  if (status == 0) return;
  std::array<char, FLEN_STATUS> text{};
  fits_get_errstatus(status, text.data());
  throw Error({path_.string(), std::string("cannot be written: ") + text.data(), {}, {}});
}

void FitsWriter::create(int bitpix, int rows, int columns, const std::vector<FitsCard>& cards) {
  int status = 0;
  std::array<long, 2> size{columns, rows};
  fits_create_img(handle(file_), bitpix, 2, size.data(), &status);
  for (const FitsCard& card : cards) write_card(handle(file_), card, status);
  check(status);
}

void FitsWriter::image(const Grid<std::uint16_t>& dn, const std::vector<FitsCard>& cards) {
  create(USHORT_IMG, dn.rows(), dn.columns(), cards);
  int status = 0;
  // CFITSIO's C interface takes data it only reads as non-const.
  auto* data = const_cast<std::uint16_t*>(dn.data());
  fits_write_img(handle(file_), TUSHORT, 1, static_cast<LONGLONG>(dn.size()), data, &status);
  check(status);
}

void FitsWriter::image(const Grid<double>& values, const std::vector<FitsCard>& cards) {
  create(DOUBLE_IMG, values.rows(), values.columns(), cards);
  int status = 0;
  auto* data = const_cast<double*>(values.data());
  fits_write_img(handle(file_), TDOUBLE, 1, static_cast<LONGLONG>(values.size()), data, &status);
  check(status);
}

void FitsWriter::close() {
  int status = 0;
  fits_close_file(handle(std::exchange(file_, nullptr)), &status);
  check(status);
}

}  // namespace scatmap::synth
