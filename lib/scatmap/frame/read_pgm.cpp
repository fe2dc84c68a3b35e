#include "scatmap/frame/read_pgm.h"

#include <fstream>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/frame/frame_size.h"
#include "scatmap/frame/samples.h"

namespace scatmap {
namespace {

constexpr int kEnd = std::char_traits<char>::eof();
constexpr int kMaxMaxval = 65535;

struct PgmStream {
  std::string file;
  std::ifstream in;
  long long bytes = 0;
};

struct PgmHeader {
  bool text = false;
  int columns = 0;
  int rows = 0;
  int maxval = 0;
};

bool is_space(int c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// The next character; a comment, from # to the end of its line, reads as that line's end.
int next(std::streambuf& buffer) {
  int c = buffer.sbumpc();
  if (c != '#') return c;
  while (c != '\n' && c != '\r' && c != kEnd) c = buffer.sbumpc();
  return c;
}

// A decimal number and the one character of white space that ends it.
int read_number(PgmStream& stream, const char* what) {
  std::streambuf& buffer = *stream.in.rdbuf();
  int c = next(buffer);
  while (is_space(c)) c = next(buffer);
  long long value = 0;
  bool digits = false;
  for (; c >= '0' && c <= '9'; c = next(buffer)) {
    digits = true;
    value = value * 10 + (c - '0');
    if (value > kMaxFramePixels) throw Error({stream.file, std::string("has a ") + what + " out of range", "", ""});
  }
  if (c == kEnd) throw Error({stream.file, std::string("is truncated in its ") + what, "", ""});
  if (!digits || !is_space(c)) {
    throw Error({stream.file, std::string("has a ") + what + " that is not a whole number",
                 std::string(1, static_cast<char>(c)), "digits"});
  }
  return static_cast<int>(value);
}

PgmHeader read_header(PgmStream& stream) {
  PgmHeader header;
  std::streambuf& buffer = *stream.in.rdbuf();
  buffer.sbumpc();  // 'P'
  header.text = buffer.sbumpc() == '2';
  const int c = next(buffer);
  if (c == kEnd) throw Error({stream.file, "is truncated after its first two bytes", "", ""});
  if (!is_space(c)) throw Error({stream.file, "is not a PGM image: white space must follow P2 or P5", "", ""});
  header.columns = read_number(stream, "width");
  header.rows = read_number(stream, "height");
  check_frame_size(stream.file, header.columns, header.rows);
  header.maxval = read_number(stream, "maxval");
  if (header.maxval < 1 || header.maxval > kMaxMaxval) {
    throw Error({stream.file, "has a maxval out of range", std::to_string(header.maxval), "1 to 65535"});
  }
  return header;
}

void check_values(const Grid<float>& dn, int maxval, const std::string& file) {
  const auto limit = static_cast<float>(maxval);
  for (std::size_t i = 0; i < dn.size(); ++i) {
    if (!(dn[i] > limit)) continue;
    const auto columns = static_cast<std::size_t>(dn.columns());
    throw Error({file + ": pixel (column " + std::to_string(i % columns) + ", row " + std::to_string(i / columns) + ")",
                 "is above maxval", std::to_string(static_cast<int>(dn[i])), "at most " + std::to_string(maxval)});
  }
}

Grid<float> read_binary(PgmStream& stream, const PgmHeader& header) {
  const int bytes_per_sample = header.maxval > 255 ? 2 : 1;
  const auto row_bytes = static_cast<long long>(header.columns) * bytes_per_sample;
  const long long expected = row_bytes * header.rows;
  const long long found = stream.bytes - static_cast<long long>(stream.in.tellg());
  if (found < expected) {
    throw Error({stream.file, "is truncated", std::to_string(found) + " bytes of pixels", std::to_string(expected)});
  }
  if (found > expected) {
    throw Error({stream.file, "does not end after its pixels: several images in one file, or a wrong header",
                 std::to_string(found) + " bytes of pixels", std::to_string(expected)});
  }
  Grid<float> dn(header.rows, header.columns);
  std::vector<unsigned char> bytes(static_cast<std::size_t>(row_bytes));
  for (int r = 0; r < header.rows; ++r) {
    if (!stream.in.read(reinterpret_cast<char*>(bytes.data()), row_bytes)) {
      throw Error({stream.file, "cannot be read", "", ""});
    }
    unpack_samples(bytes.data(), bytes_per_sample, dn.row(r));
  }
  return dn;
}

Grid<float> read_text(PgmStream& stream, const PgmHeader& header) {
  const auto pixels = static_cast<long long>(header.columns) * header.rows;
  const long long found = stream.bytes - static_cast<long long>(stream.in.tellg());
  if (found < 2 * pixels) {  // a digit and a space
    throw Error({stream.file, "is truncated", std::to_string(found) + " bytes of pixels",
                 "at least " + std::to_string(2 * pixels)});
  }
  Grid<float> dn(header.rows, header.columns);
  for (float& value : dn) {
    const int number = read_number(stream, "list of pixels");
    value = static_cast<float>(number);  // rounded beyond 2^24, but then it is above maxval
  }
  std::streambuf& buffer = *stream.in.rdbuf();
  int c = next(buffer);
  while (is_space(c)) c = next(buffer);
  if (c != kEnd)
    throw Error({stream.file, "does not end after its pixels: several images in one file, or a wrong header", "", ""});
  return dn;
}

}  // namespace

Frame read_pgm(const std::filesystem::path& path) {
  PgmStream stream{.file = path.string(), .in = std::ifstream(path, std::ios::binary)};
  if (!stream.in) throw Error({stream.file, "cannot be opened for reading", "", ""});
  stream.bytes = static_cast<long long>(std::filesystem::file_size(path));
  const PgmHeader header = read_header(stream);
  Grid<float> dn = header.text ? read_text(stream, header) : read_binary(stream, header);
  check_values(dn, header.maxval, stream.file);
  return {.dn = std::move(dn), .quantum_dn = 1, .file = path, .header = {}};
}

}  // namespace scatmap
