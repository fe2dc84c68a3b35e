#include "scatmap/frame/read_fits.h"

#include <fitsio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/frame/fits_checksum.h"
#include "scatmap/frame/fits_frame_header.h"
#include "scatmap/frame/fits_pixels.h"
#include "scatmap/frame/fits_structure.h"
#include "scatmap/frame/frame_size.h"

namespace scatmap {
namespace {

constexpr double kExactInFloat = 1 << 24;

struct PixelScale {
  double zero_dn = 0;
  double step_dn = 1;
  std::optional<long long> blank;
};

void check_cfitsio(int status, const std::string& file) {
  if (status == 0) return;
  std::array<char, FLEN_STATUS> text{};
  fits_get_errstatus(status, text.data());
  fits_clear_errmsg();
  throw Error({file, "cannot be read by CFITSIO: " + std::string(text.data()), "", ""});
}

class FitsFile {
 public:
  // The disk-only open takes brackets and parentheses as part of the name, and an absolute path keeps it from
  // dropping leading blanks and from expanding a leading tilde.
  explicit FitsFile(const std::filesystem::path& path) : name_(path.string()) {
    const std::string absolute = std::filesystem::absolute(path).string();
    if (absolute.size() >= FLEN_FILENAME) {
      throw Error({name_, "has a path too long for CFITSIO", std::to_string(absolute.size()) + " bytes",
                   "at most " + std::to_string(FLEN_FILENAME - 1)});
    }
    int status = 0;
    fits_open_diskfile(&file_, absolute.c_str(), READONLY, &status);
    check_cfitsio(status, name_);
  }
  FitsFile(const FitsFile&) = delete;
  FitsFile& operator=(const FitsFile&) = delete;
  ~FitsFile() {
    int status = 0;
    fits_close_file(file_, &status);
    fits_clear_errmsg();
  }
  fitsfile* get() const { return file_; }
  void check(int status) const { check_cfitsio(status, name_); }

 private:
  std::string name_;
  fitsfile* file_ = nullptr;
};

std::string listed(const std::vector<const FitsHdu*>& images) {
  std::string text;
  for (const FitsHdu* image : images) text += (text.empty() ? "" : ", ") + image->name;
  return text;
}

const FitsHdu& the_image(const std::vector<FitsHdu>& hdus, const std::string& file) {
  if (hdus.front().image) return hdus.front();
  std::vector<const FitsHdu*> images;
  for (const FitsHdu& hdu : hdus) {
    if (hdu.image) images.push_back(&hdu);
  }
  if (images.empty()) throw Error({file, "holds no image", "", "one image"});
  if (images.size() > 1) {
    throw Error(
        {file, "holds several images", std::to_string(images.size()) + " (" + listed(images) + ")", "one image"});
  }
  return *images.front();
}

// What scatmap writes is no raw frame, though its first image may look like one.
void refuse_maps(const std::vector<FitsHdu>& hdus) {
  constexpr std::array<std::string_view, 4> kMapImages{"BRDF", "THETA_S_DEG", "PHI_S_DEG", "SOLID_ANGLE_SR"};
  const auto says = [](const FitsHdu& hdu, const char* key) {
    const FitsCard* card = hdu.header.find(key);
    return card != nullptr && card->quoted ? card->value : std::string();
  };
  for (const FitsHdu& hdu : hdus) {
    if (says(hdu, "BUNIT") == "sr-1")
      throw Error({hdu.header.where(*hdu.header.find("BUNIT")), "says a BRDF map, not a raw frame", "sr-1", "counts"});
    const std::string name = says(hdu, "EXTNAME");
    if (std::find(kMapImages.begin(), kMapImages.end(), name) == kMapImages.end()) continue;
    throw Error({hdu.header.where(*hdu.header.find("EXTNAME")), "says a map, not a raw frame", name, "counts"});
  }
}

void check_is_plane(const FitsHdu& image, const std::string& file) {
  const auto& axes = image.axes;
  if (axes.size() < 2)
    throw Error({image.header.where(), "holds a row of values, not an image", "NAXIS = 1", "NAXIS = 2"});
  if (axes.size() > 3) {
    throw Error({image.header.where(), "has too many axes", std::to_string(axes.size()), "NAXIS = 2"});
  }
  if (axes.size() == 3 && axes[2] != 1) {
    throw Error(
        {image.header.where(), "is a cube of several images", std::to_string(axes[2]) + " planes", "one plane"});
  }
  check_frame_size(file, axes[0], axes[1]);
}

PixelScale pixel_scale(const FitsHdu& image) {
  PixelScale scale;
  const FitsHeader& h = image.header;
  scale.zero_dn = h.number("BZERO").value_or(0);
  scale.step_dn = h.number("BSCALE").value_or(1);
  if (scale.step_dn == 0) throw Error({h.where(*h.find("BSCALE")), "makes every pixel equal", "0", "another number"});
  if (image.bitpix > 0) scale.blank = h.integer("BLANK");
  return scale;
}

// CFITSIO parses the header again; should it see another image than was checked, nothing is read.
void check_same_image(const FitsFile& file, const FitsHdu& image) {
  int status = 0;
  int bitpix = 0;
  int axes = 0;
  std::array<long long, 3> lengths{};
  fits_get_img_paramll(file.get(), static_cast<int>(lengths.size()), &bitpix, &axes, lengths.data(), &status);
  file.check(status);
  bool same = bitpix == image.bitpix && axes == static_cast<int>(image.axes.size());
  for (std::size_t i = 0; same && i < image.axes.size(); ++i) same = lengths[i] == image.axes[i];
  if (!same) throw Error({image.header.where(), "is read differently by CFITSIO", "", ""});
}

void set_scale(const FitsFile& file, const PixelScale& scale) {
  int status = 0;
  fits_set_bscale(file.get(), scale.step_dn, scale.zero_dn, &status);
  if (scale.blank) fits_set_imgnull(file.get(), *scale.blank, &status);
  file.check(status);
}

// NaN asks CFITSIO to put NaN where BLANK is; without BLANK no pointer is given, which is faster and keeps the
// infinities and NaNs of floating-point files as they are.
template <class T>
void read_pixels(const FitsFile& file, int type, long long first, std::span<T> values, bool has_blank) {
  T nan = std::numeric_limits<T>::quiet_NaN();
  int status = 0;
  int any = 0;
  fits_read_img(file.get(), type, first, static_cast<long long>(values.size()), has_blank ? &nan : nullptr,
                values.data(), &any, &status);
  file.check(status);
}

// Largest magnitude a pixel may have to become a float without losing a step (integers) or overflowing (doubles).
double largest_dn(const FitsHdu& image, const PixelScale& scale) {
  return image.bitpix > 0 ? kExactInFloat * std::abs(scale.step_dn)
                          : static_cast<double>(std::numeric_limits<float>::max());
}

bool cannot_exceed(const FitsHdu& image, const PixelScale& scale) {
  if (image.bitpix < 0) return image.bitpix == -32 && scale.step_dn == 1 && scale.zero_dn == 0;
  return std::abs(scale.zero_dn) + std::ldexp(std::abs(scale.step_dn), image.bitpix) <= largest_dn(image, scale);
}

void read_checked(const FitsFile& file, const FitsHdu& image, const PixelScale& scale, Grid<float>& dn) {
  const double limit_dn = largest_dn(image, scale);
  std::vector<double> row(static_cast<std::size_t>(dn.columns()));
  for (int r = 0; r < dn.rows(); ++r) {
    read_pixels<double>(file, TDOUBLE, 1LL + static_cast<long long>(r) * dn.columns(), row, scale.blank.has_value());
    for (int c = 0; c < dn.columns(); ++c) {
      const double value = row[static_cast<std::size_t>(c)];
      if (std::isfinite(value) && std::abs(value) > limit_dn) {
        throw Error({image.header.where() + ", pixel (column " + std::to_string(c) + ", row " + std::to_string(r) + ")",
                     image.bitpix > 0 ? "is beyond 2^24 steps and would be rounded" : "is too large for a float",
                     std::to_string(value), "at most " + std::to_string(limit_dn)});
      }
      dn(r, c) = static_cast<float>(value);
    }
  }
}

// Whole numbers that a float holds exactly, whichever way they are computed.
bool is_plain_integer(const FitsHdu& image, const PixelScale& scale) {
  constexpr double kLargestZero = 1 << 22;
  return (image.bitpix == 8 || image.bitpix == 16) && !scale.blank && scale.step_dn == 1 &&
         std::abs(scale.zero_dn) <= kLargestZero && scale.zero_dn == std::round(scale.zero_dn);
}

void read_by_cfitsio(const std::filesystem::path& path, const FitsHdu& image, const PixelScale& scale,
                     Grid<float>& dn) {
  const FitsFile file(path);
  int status = 0;
  fits_movabs_hdu(file.get(), image.header.hdu(), nullptr, &status);
  file.check(status);
  check_same_image(file, image);
  set_scale(file, scale);
  if (cannot_exceed(image, scale)) {
    read_pixels<float>(file, TFLOAT, 1, {dn.data(), dn.size()}, scale.blank.has_value());
  } else {
    read_checked(file, image, scale, dn);
  }
}

struct ReadFrame {
  Frame frame;
  bool hashed;
};

ReadFrame read(const std::filesystem::path& path, InputHash* hash) {
  const std::vector<FitsHdu> hdus = check_fits_structure(path);
  refuse_maps(hdus);
  const FitsHdu& image = the_image(hdus, path.string());
  check_is_plane(image, path.string());
  require_fits_data_sum(path, image);
  const PixelScale scale = pixel_scale(image);
  const bool primary = image.header.hdu() == 1;
  Frame frame{.dn = {}, .quantum_dn = image.bitpix > 0 ? std::abs(scale.step_dn) : 0, .file = path, .header = {}};
  frame.header = primary ? fits_frame_header(image.header) : fits_frame_header(image.header, hdus.front().header);
  const int rows = static_cast<int>(image.axes[1]), columns = static_cast<int>(image.axes[0]);
  constexpr double kUnsignedZero = 32768;
  if (!is_plain_integer(image, scale)) {
    Grid<float> dn(rows, columns);
    read_by_cfitsio(path, image, scale, dn);
    frame.dn = std::move(dn);
    return {std::move(frame), false};
  }
  if (image.bitpix == 16 && scale.zero_dn == kUnsignedZero) {
    Grid<std::uint16_t> dn(rows, columns);
    read_fits_pixels(path, image, {dn.data(), dn.size()}, hash);
    frame.dn = std::move(dn);
  } else {
    Grid<float> dn(rows, columns);
    read_fits_pixels(path, image, static_cast<float>(scale.zero_dn), {dn.data(), dn.size()}, hash);
    frame.dn = std::move(dn);
  }
  return {std::move(frame), true};
}

}  // namespace

Frame read_fits(const std::filesystem::path& path) { return read(path, nullptr).frame; }

RecordedFrame read_recorded_fits(const std::filesystem::path& path) {
  InputHash hash;
  ReadFrame of = read(path, &hash);
  return {std::move(of.frame), of.hashed ? hash.record(path) : record_input(path)};
}

}  // namespace scatmap
