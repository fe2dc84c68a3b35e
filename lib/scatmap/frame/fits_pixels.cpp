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

}  // namespace

void read_fits_pixels(const std::filesystem::path& path, const FitsHdu& image, float zero_dn, std::span<float> dn,
                      InputHash* hash) {
  // Small enough for the second-level cache: summed and decoded before it leaves it. Even, so no pixel is torn.
  constexpr std::size_t kBlock = std::size_t{1} << 18;
  const ReadOnlyFile file(path);
  std::vector<unsigned char> block(kBlock);
  const long long size = image.bitpix / 8, begin = image.data_offset,
                  end = begin + size * static_cast<long long>(dn.size());
  long long at = 0;
  while (hash != nullptr || at < end) {
    const std::size_t filled = file.read_block(block);
    if (hash != nullptr) hash->add({block.data(), filled});
    const long long first = std::max(at, begin),
                    last = std::min(at + static_cast<long long>(filled), end) / size * size;
    if (first < last) {
      const unsigned char* from = block.data() + (first - at);
      float* to = dn.data() + (first - begin) / size;
      size == 1 ? decode_bytes(from, zero_dn, last - first, to)
                : decode_words(from, zero_dn, (last - first) / size, to);
    }
    at += static_cast<long long>(filled);
    if (filled < block.size()) break;
  }
  if (at < end) throw Error({image.header.where(), "was cut short while it was read", "", ""});
}

}  // namespace scatmap
