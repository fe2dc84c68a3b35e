#include "scatmap/report/fits_image_data.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/base/parallel.h"
#include "scatmap/frame/fits_sum.h"
#include "scatmap/report/fits_bytes.h"

namespace scatmap {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 15;  // pixels; with their copies in the second-level cache. Even
constexpr std::int64_t kRecord = 2880;

// One thread's buffers.
struct Block {
  std::vector<double> doubles = std::vector<double>(kBlock);
  std::vector<float> floats = std::vector<float>(kBlock);
  std::vector<unsigned char> bytes = std::vector<unsigned char>(kBlock * sizeof(double));
};

struct Encoded {
  std::uint32_t sum;
  std::size_t bytes;
};

Encoded encode(std::span<const float> pixels, const FitsImageData&, Block& b) {
  fits_bytes_of_floats(pixels, b.bytes.data());
  return {fits_sum_of_floats(pixels), pixels.size() * sizeof(float)};
}

Encoded encode(std::span<const Mask> pixels, const FitsImageData&, Block& b) {
  fits_bytes_of_masks(pixels, b.bytes.data());
  return {fits_sum_of_masks(pixels), pixels.size() * sizeof(Mask)};
}

Encoded encode(std::span<const double> pixels, const FitsImageData& data, Block& b) {
  if (data.stored == FitsPixels::kFloat) {
    scale_pixels(pixels, data.factor, b.floats.data());
    return encode(std::span<const float>(b.floats.data(), pixels.size()), data, b);
  }
  if (data.factor != 1) {
    scale_pixels(pixels, data.factor, b.doubles.data());
    pixels = {b.doubles.data(), pixels.size()};
  }
  fits_bytes_of_doubles(pixels, b.bytes.data());
  return {fits_sum_of_doubles(pixels), pixels.size() * sizeof(double)};
}

}  // namespace

PositionedFile::PositionedFile(const std::filesystem::path& path, std::string target)
    : target_(std::move(target)), descriptor_(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) fail();
}

PositionedFile::~PositionedFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void PositionedFile::fail() const {
  throw Error({target_, std::string("cannot be written: ") + std::strerror(errno), {}, {}});
}

void PositionedFile::write(const void* bytes, std::size_t count, std::int64_t at) const {
  const char* from = static_cast<const char*>(bytes);
  while (count > 0) {
    const ssize_t n = pwrite(descriptor_, from, count, at);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail();
    from += n;
    at += n;
    count -= static_cast<std::size_t>(n);
  }
}

void PositionedFile::begin_to_store(std::int64_t at, std::int64_t count) const {
#ifdef SYNC_FILE_RANGE_WRITE
  sync_file_range(descriptor_, at, count, SYNC_FILE_RANGE_WRITE);
#endif
}

void PositionedFile::close() {
  const int failed = ::close(std::exchange(descriptor_, -1));
  if (failed != 0) fail();
}

std::int64_t FitsImageData::bytes() const {
  return std::visit(
      [&](const auto* grid) {
        using T = std::decay_t<decltype((*grid)[0])>;
        const bool narrowed = std::is_same_v<T, double> && stored == FitsPixels::kFloat;
        return static_cast<std::int64_t>(grid->size() * (narrowed ? sizeof(float) : sizeof(T)));
      },
      pixels);
}

std::uint32_t write_image_data(const FitsImageData& data, const PositionedFile& file, std::int64_t at) {
  std::vector<std::uint32_t> sums;
  std::visit(
      [&](const auto* grid) {
        const std::size_t pixels = grid->size();
        sums.resize((pixels + kBlock - 1) / kBlock);
        const auto pixel_bytes = pixels == 0 ? 0 : data.bytes() / static_cast<std::int64_t>(pixels);
        for_ranges(sums.size(), std::size_t{4}, [&](std::size_t from, std::size_t to) {
          Block block;
          for (std::size_t i = from; i < to; ++i) {
            const std::size_t first = i * kBlock, count = std::min(kBlock, pixels - first);
            const Encoded e = encode(std::span(grid->data() + first, count), data, block);
            sums[i] = e.sum;
            file.write(block.bytes.data(), e.bytes, at + static_cast<std::int64_t>(first) * pixel_bytes);
          }
        });
      },
      data.pixels);
  const std::vector<unsigned char> padding(static_cast<std::size_t>((kRecord - data.bytes() % kRecord) % kRecord));
  file.write(padding.data(), padding.size(), at + data.bytes());
  file.begin_to_store(at, data.bytes());
  std::uint64_t sum = 0;
  for (const std::uint32_t s : sums) sum += s;
  return fits_sum_folded(sum);
}

}  // namespace scatmap
