#include "scatmap/base/provenance.h"

#include <nettle/sha2.h>

#include <array>
#include <fstream>
#include <vector>

#include "scatmap/base/error.h"

namespace scatmap {

std::string version() { return SCATMAP_VERSION; }

InputRecord record_input(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error({path.string(), "cannot be read", {}, {}});
  sha256_ctx context;
  sha256_init(&context);
  std::vector<char> block(std::size_t{1} << 20);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) || stream.gcount() > 0) {
    sha256_update(&context, static_cast<std::size_t>(stream.gcount()), reinterpret_cast<const std::uint8_t*>(block.data()));
  }
  std::array<std::uint8_t, SHA256_DIGEST_SIZE> digest{};
  sha256_digest(&context, digest.size(), digest.data());
  std::string hex;
  for (const std::uint8_t byte : digest) {
    constexpr const char* kDigits = "0123456789abcdef";
    hex += kDigits[byte >> 4];
    hex += kDigits[byte & 15];
  }
  return {path.string(), hex};
}

}  // namespace scatmap
