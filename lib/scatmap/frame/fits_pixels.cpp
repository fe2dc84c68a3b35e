#include "scatmap/frame/fits_pixels.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "scatmap/base/error.h"

namespace scatmap {
namespace {

class ReadOnlyFile {
 public:
  explicit ReadOnlyFile(const std::filesystem::path& path)
      : name_(path.string()), descriptor_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0) throw Error({name_, "cannot be opened for reading", "", ""});
  }
  ~ReadOnlyFile() { close(descriptor_); }
  ReadOnlyFile(const ReadOnlyFile&) = delete;
  ReadOnlyFile& operator=(const ReadOnlyFile&) = delete;

  // As many of `bytes` as the file still has.
  std::size_t read_block(std::span<unsigned char> bytes) const {
    std::size_t filled = 0;
    while (filled < bytes.size()) {
      const ssize_t got = read(descriptor_, bytes.data() + filled, bytes.size() - filled);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) throw Error({name_, std::string("cannot be read: ") + std::strerror(errno), "", ""});
      if (got == 0) break;
      filled += static_cast<std::size_t>(got);
    }
    return filled;
  }

 private:
  std::string name_;
  int descriptor_;
};

// Calls decode(bytes, first, pixels) for blocks of an image.
template <class Decode>
void read_blocks(const std::filesystem::path& path, const FitsHdu& image, std::size_t pixels, InputHash* hash,
                 Decode&& decode) {
  // Small enough for the second-level cache: summed and decoded before it leaves it. Even, so no pixel is torn.
  constexpr std::size_t kBlock = std::size_t{1} << 18;
  const ReadOnlyFile file(path);
  std::vector<unsigned char> block(kBlock);
  const long long size = image.bitpix / 8, begin = image.data_offset,
                  end = begin + size * static_cast<long long>(pixels);
  long long at = 0;
  while (hash != nullptr || at < end) {
    const std::size_t filled = file.read_block(block);
    if (hash != nullptr) hash->add({block.data(), filled});
    const long long first = std::max(at, begin),
                    last = std::min(at + static_cast<long long>(filled), end) / size * size;
    if (first < last) decode(block.data() + (first - at), (first - begin) / size, (last - first) / size);
    at += static_cast<long long>(filled);
    if (filled < block.size()) break;
  }
  if (at < end) throw Error({image.header.where(), "was cut short while it was read", "", ""});
}

}  // namespace

void read_fits_pixels(const std::filesystem::path& path, const FitsHdu& image, float zero_dn, std::span<float> dn,
                      InputHash* hash) {
  read_blocks(path, image, dn.size(), hash, [&](const unsigned char* from, long long first, long long pixels) {
    image.bitpix == 8 ? decode_bytes(from, zero_dn, pixels, dn.data() + first)
                      : decode_words(from, zero_dn, pixels, dn.data() + first);
  });
}

void read_fits_pixels(const std::filesystem::path& path, const FitsHdu& image, std::span<std::uint16_t> dn,
                      InputHash* hash) {
  read_blocks(path, image, dn.size(), hash, [&](const unsigned char* from, long long first, long long pixels) {
    decode_unsigned_words(from, pixels, dn.data() + first);
  });
}

}  // namespace scatmap
