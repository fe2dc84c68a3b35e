#include "scatmap/base/provenance.h"

#include <nettle/sha2.h>

#include <array>
#include <fstream>
#include <vector>

#include "scatmap/base/error.h"

namespace scatmap {

std::string version() { return SCATMAP_VERSION; }

namespace {

// Bytes of the well-formed UTF-8 sequence at i, 0 if there is none (RFC 3629; overlong forms and surrogates are
// ill-formed).
std::size_t sequence_length(const std::string& s, std::size_t i) {
  const auto byte = [&](std::size_t k) { return k < s.size() ? static_cast<unsigned char>(s[k]) : 0u; };
  const auto follows = [&](std::size_t k, unsigned low, unsigned high) { return byte(k) >= low && byte(k) <= high; };
  const unsigned b = byte(i);
  if (b < 0x80) return 1;
  if (b >= 0xC2 && b <= 0xDF) return follows(i + 1, 0x80, 0xBF) ? 2 : 0;
  if (b >= 0xE0 && b <= 0xEF) {
    const bool second = follows(i + 1, b == 0xE0 ? 0xA0 : 0x80, b == 0xED ? 0x9F : 0xBF);
    return second && follows(i + 2, 0x80, 0xBF) ? 3 : 0;
  }
  if (b >= 0xF0 && b <= 0xF4) {
    const bool second = follows(i + 1, b == 0xF0 ? 0x90 : 0x80, b == 0xF4 ? 0x8F : 0xBF);
    return second && follows(i + 2, 0x80, 0xBF) && follows(i + 3, 0x80, 0xBF) ? 4 : 0;
  }
  return 0;
}

}  // namespace

std::string utf8_text(const std::string& bytes) {
  std::string out;
  for (std::size_t i = 0; i < bytes.size();) {
    const std::size_t length = sequence_length(bytes, i);
    out += length > 0 ? bytes.substr(i, length) : "?";
    i += length > 0 ? length : 1;
  }
  return out;
}

struct InputHash::State {
  sha256_ctx context;
};

InputHash::InputHash() : state_(std::make_unique<State>()) { sha256_init(&state_->context); }
InputHash::~InputHash() = default;

void InputHash::add(std::span<const unsigned char> bytes) {
  sha256_update(&state_->context, bytes.size(), bytes.data());
}

InputRecord InputHash::record(const std::filesystem::path& path) {
  std::array<std::uint8_t, SHA256_DIGEST_SIZE> digest{};
  sha256_digest(&state_->context, digest.size(), digest.data());
  std::string hex;
  for (const std::uint8_t byte : digest) {
    constexpr const char* kDigits = "0123456789abcdef";
    hex += kDigits[byte >> 4];
    hex += kDigits[byte & 15];
  }
  return {utf8_text(path.string()), hex};
}

InputRecord record_input(const std::filesystem::path& path) { return record_input(path, file_state(path)); }

InputRecord record_input(const std::filesystem::path& path, const FileState& as_read) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error({path.string(), "cannot be read", {}, {}});
  InputHash hash;
  std::vector<char> block(std::size_t{1} << 20);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) || stream.gcount() > 0) {
    hash.add({reinterpret_cast<const unsigned char*>(block.data()), static_cast<std::size_t>(stream.gcount())});
  }
  require_unchanged(path, as_read);
  return hash.record(path);
}

}  // namespace scatmap
