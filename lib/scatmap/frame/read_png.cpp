#include "scatmap/frame/read_png.h"

#include <png.h>

#include <array>
#include <csetjmp>
#include <cstdio>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/frame/frame_size.h"
#include "scatmap/frame/samples.h"

namespace scatmap {
namespace {

// libpng leaves by longjmp. The functions that call setjmp hold nothing with a destructor: all of it lives here.
struct PngFile {
  std::FILE* file = nullptr;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::array<char, 256> message{};

  PngFile() = default;
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;
  ~PngFile() {
    png_destroy_read_struct(&png, &info, nullptr);
    if (file != nullptr) std::fclose(file);
  }
};

[[noreturn]] void on_error(png_structp png, png_const_charp text) {
  auto* owner = static_cast<PngFile*>(png_get_error_ptr(png));
  std::snprintf(owner->message.data(), owner->message.size(), "%s", text);
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

bool read_info(PngFile& f) {
  if (setjmp(png_jmpbuf(f.png)) != 0) return false;
  png_init_io(f.png, f.file);
  png_set_crc_action(f.png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
  png_read_info(f.png, f.info);
  return true;
}

bool read_rows(PngFile& f, png_bytep pixels, std::size_t row_bytes, png_uint_32 rows) {
  if (setjmp(png_jmpbuf(f.png)) != 0) return false;
  const int passes = png_set_interlace_handling(f.png);
  png_read_update_info(f.png, f.info);
  for (int pass = 0; pass < passes; ++pass) {
    for (png_uint_32 r = 0; r < rows; ++r) png_read_row(f.png, pixels + r * row_bytes, nullptr);
  }
  png_read_end(f.png, nullptr);
  return true;
}

void open(PngFile& f, const std::string& name) {
  f.file = std::fopen(name.c_str(), "rb");
  if (f.file == nullptr) throw Error({name, "cannot be opened for reading", "", ""});
  f.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &f, on_error, on_warning);
  if (f.png != nullptr) f.info = png_create_info_struct(f.png);
  if (f.info == nullptr) throw std::bad_alloc();
}

[[noreturn]] void fail(const PngFile& f, const std::string& name) {
  throw Error({name, "is truncated or damaged: libpng says '" + std::string(f.message.data()) + "'", "", ""});
}

void check_grey(const PngFile& f, const std::string& name) {
  const int type = png_get_color_type(f.png, f.info);
  if (type == PNG_COLOR_TYPE_PALETTE) throw Error({name, "has a colour palette, not grey values", "", ""});
  if ((type & PNG_COLOR_MASK_COLOR) != 0) throw Error({name, "is a colour image, not grey", "", ""});
  if ((type & PNG_COLOR_MASK_ALPHA) != 0 || png_get_valid(f.png, f.info, PNG_INFO_tRNS) != 0) {
    throw Error({name, "has transparency, which counts do not have", "", "grey only"});
  }
  const int bits = png_get_bit_depth(f.png, f.info);
  if (bits != 8 && bits != 16) throw Error({name, "has too few bits", std::to_string(bits) + " bit", "8 or 16 bit"});
}

}  // namespace

Frame read_png(const std::filesystem::path& path) {
  const std::string name = path.string();
  PngFile f;
  open(f, name);
  if (!read_info(f)) fail(f, name);
  check_grey(f, name);
  const png_uint_32 columns = png_get_image_width(f.png, f.info);
  const png_uint_32 rows = png_get_image_height(f.png, f.info);
  check_frame_size(name, columns, rows);
  check_enough_data(name, static_cast<long long>(columns) * rows,
                    static_cast<long long>(std::filesystem::file_size(path)));
  const int bytes_per_sample = png_get_bit_depth(f.png, f.info) / 8;
  const std::size_t row_bytes = std::size_t{columns} * static_cast<std::size_t>(bytes_per_sample);
  std::vector<unsigned char> pixels(row_bytes * rows);
  if (!read_rows(f, pixels.data(), row_bytes, rows)) fail(f, name);
  Grid<float> dn(static_cast<int>(rows), static_cast<int>(columns));
  unpack_samples(pixels.data(), bytes_per_sample, {dn.data(), dn.size()});
  return {.dn = std::move(dn), .quantum_dn = 1, .file = path, .header = {}};
}

}  // namespace scatmap
