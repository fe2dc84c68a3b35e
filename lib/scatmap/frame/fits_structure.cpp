#include "scatmap/frame/fits_structure.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <set>

#include "scatmap/base/error.h"

namespace scatmap {
namespace {

struct FitsStream {
  std::string file;
  std::ifstream in;
  long long bytes = 0;
  long long at = 0;
  int header_blocks = 0;
};

bool is_axis_key(const std::string& key) {
  return key.size() > 5 && key.starts_with("NAXIS") && key.find_first_not_of("0123456789", 5) == std::string::npos;
}

bool is_structural(const std::string& key) {
  static constexpr std::array kKeys{"SIMPLE", "XTENSION", "BITPIX", "NAXIS",  "PCOUNT", "GCOUNT",
                                    "GROUPS", "TFIELDS",  "BZERO",  "BSCALE", "BLANK"};
  return is_axis_key(key) || std::find(kKeys.begin(), kKeys.end(), key) != kKeys.end();
}

std::string read_block(FitsStream& stream, const FitsHeader& header) {
  if (++stream.header_blocks > kMaxFitsHeaderBlocks) {
    throw Error({header.where(), "has too long a header, or none of its cards is END", "",
                 "at most " + std::to_string(kMaxFitsHeaderBlocks) + " header blocks in a file"});
  }
  std::string block(static_cast<std::size_t>(kFitsBlockBytes), '\0');
  stream.in.seekg(stream.at);
  stream.in.read(block.data(), kFitsBlockBytes);
  if (stream.in.gcount() != kFitsBlockBytes) {
    throw Error({header.where(), "is truncated: the file ends before the END card of the header",
                 std::to_string(stream.bytes) + " bytes", ""});
  }
  stream.at += kFitsBlockBytes;
  return block;
}

FitsHeader read_header(FitsStream& stream, int hdu) {
  FitsHeader header(stream.file, hdu);
  while (true) {
    const std::string block = read_block(stream, header);
    for (std::size_t i = 0; i < block.size(); i += kFitsCardBytes) {
      const std::string_view card(block.data() + i, kFitsCardBytes);
      if (card.starts_with("END     ")) {
        if (card.find_first_not_of(' ', 3) == std::string_view::npos) return header;
        throw Error({header.where(), "has an END card that is not blank after END", "", ""});
      }
      header.add(card);
    }
  }
}

// The order is fixed by the standard, and readers that search and readers that count must see the same thing.
void check_order(const FitsHeader& header, std::size_t index, const std::string& key) {
  const auto& cards = header.cards();
  const std::string position = header.where() + ", card " + std::to_string(index + 1);
  if (index >= cards.size()) throw Error({position, "is missing", "END", key});
  if (cards[index].key != key)
    throw Error({position, "is not the keyword that must stand here", cards[index].key, key});
}

void check_structural_once(const FitsHeader& header, long long axes) {
  std::set<std::string> seen;
  for (const FitsCard& card : header.cards()) {
    if (card.key == "ZIMAGE") {
      throw Error({header.where(card), "is a tile-compressed image; run funpack on the file first", "", ""});
    }
    if (!is_structural(card.key)) continue;
    if (!seen.insert(card.key).second) throw Error({header.where(card), "stands twice", "", "once"});
    if (!card.has_value) throw Error({header.where(card), "has no value", "", "'= ' in columns 9 and 10"});
    if (card.number > 1 && (card.key == "SIMPLE" || card.key == "XTENSION")) {
      throw Error({header.where(card), "stands in the middle of a header", "", "the first card"});
    }
    if (is_axis_key(card.key) && (card.number < 4 || card.number > 3 + axes)) {
      throw Error({header.where(card), "contradicts NAXIS", "", std::to_string(axes) + " axes"});
    }
  }
}

long long limited(const FitsHeader& header, const std::string& key, long long least, long long most) {
  const auto value = header.integer(key);
  if (!value) throw Error({header.where(), "has no " + key, "", ""});
  if (*value < least || *value > most) {
    throw Error({header.where(*header.find(key)), "is out of range", std::to_string(*value),
                 std::to_string(least) + " to " + std::to_string(most)});
  }
  return *value;
}

int bitpix_of(const FitsHeader& header) {
  const long long bitpix = header.integer("BITPIX").value_or(0);
  for (const int known : {8, 16, 32, -32, -64}) {
    if (bitpix == known) return known;
  }
  throw Error({header.where(*header.find("BITPIX")), "is not a pixel type scatmap reads", std::to_string(bitpix),
               "8, 16, 32, -32 or -64"});
}

// Every factor is held against the size of the file before it is multiplied, so nothing overflows.
long long product_within(const FitsHeader& header, std::vector<long long> factors, long long limit) {
  if (std::find(factors.begin(), factors.end(), 0) != factors.end()) return 0;
  long long product = 1;
  for (const long long factor : factors) {
    if (product > limit / factor) {
      throw Error({header.where(), "is truncated: its header announces more data than the file has",
                   std::to_string(limit) + " bytes in the file", ""});
    }
    product *= factor;
  }
  return product;
}

// Kind of HDU by its first card: "" is the primary.
std::string extension_type(const FitsHeader& header) {
  if (header.hdu() > 1) {
    check_order(header, 0, "XTENSION");
    return header.text("XTENSION").value_or("");
  }
  check_order(header, 0, "SIMPLE");
  if (!header.logical("SIMPLE").value_or(false)) {
    throw Error({header.where(header.cards()[0]), "says the file does not conform to FITS", "F", "T"});
  }
  return "";
}

void check_image(const FitsHeader& header, bool extension) {
  if (header.find("GROUPS") != nullptr && header.logical("GROUPS").value_or(false)) {
    throw Error({header.where(*header.find("GROUPS")), "announces random groups, not an image", "", ""});
  }
  if (extension || header.find("PCOUNT") != nullptr) limited(header, "PCOUNT", 0, 0);
  if (extension || header.find("GCOUNT") != nullptr) limited(header, "GCOUNT", 1, 1);
}

// CFITSIO counts cards and reserves memory for what it takes for TFIELDS before it looks for the columns.
void check_table(const FitsHeader& header) {
  limited(header, "NAXIS", 2, 2);
  check_order(header, 5, "PCOUNT");
  check_order(header, 6, "GCOUNT");
  check_order(header, 7, "TFIELDS");
  limited(header, "TFIELDS", 0, kMaxFitsColumns);
}

long long data_bytes_of(const FitsHdu& hdu, bool plain_image, long long file_bytes) {
  std::vector<long long> factors = hdu.axes;
  if (factors.empty()) factors.push_back(0);
  if (plain_image) {
    factors.push_back(std::abs(hdu.bitpix) / 8);
    return product_within(hdu.header, factors, file_bytes);
  }
  const long long heap = limited(hdu.header, "PCOUNT", 0, kMaxFitsAxis);
  const long long groups = limited(hdu.header, "GCOUNT", 1, kMaxFitsAxis);
  const long long elements = product_within(hdu.header, factors, file_bytes) + heap;
  return product_within(hdu.header, {elements, groups, std::abs(hdu.bitpix) / 8}, file_bytes);
}

FitsHdu checked_hdu(FitsHeader&& header, long long file_bytes) {
  FitsHdu hdu{.header = std::move(header),
              .name = {},
              .image = false,
              .bitpix = 0,
              .axes = {},
              .offset = 0,
              .data_bytes = 0,
              .data_offset = 0};
  const FitsHeader& h = hdu.header;
  const std::string type = extension_type(h);
  check_order(h, 1, "BITPIX");
  check_order(h, 2, "NAXIS");
  const long long axes = limited(h, "NAXIS", 0, kMaxFitsAxes);
  check_structural_once(h, axes);
  hdu.bitpix = bitpix_of(h);
  for (long long i = 1; i <= axes; ++i) {
    const std::string key = "NAXIS" + std::to_string(i);
    check_order(h, static_cast<std::size_t>(2 + i), key);
    hdu.axes.push_back(limited(h, key, 0, kMaxFitsAxis));
  }
  const bool plain_image = type.empty() || type == "IMAGE";
  if (plain_image) check_image(h, !type.empty());
  hdu.data_bytes = data_bytes_of(hdu, plain_image, file_bytes);
  if (type == "BINTABLE" || type == "TABLE") check_table(h);
  hdu.image = plain_image && hdu.data_bytes > 0;
  const std::string number = "HDU " + std::to_string(h.hdu());
  hdu.name = h.hdu() == 1 ? "primary" : h.find("EXTNAME") != nullptr ? h.text("EXTNAME").value_or(number) : number;
  return hdu;
}

void skip_data(FitsStream& stream, const FitsHdu& hdu) {
  const long long padded = hdu.padded_bytes();
  const long long present = stream.bytes - stream.at;
  if (present < padded) {
    throw Error({hdu.header.where(), "is truncated", std::to_string(std::max(present, 0LL)) + " bytes of data",
                 std::to_string(padded) + " (" + std::to_string(hdu.data_bytes) + " filled to whole blocks of 2880)"});
  }
  stream.at += padded;
}

bool at_extension(FitsStream& stream) {
  std::array<char, 8> begin{};
  stream.in.clear();
  stream.in.seekg(stream.at);
  stream.in.read(begin.data(), begin.size());
  return stream.in.gcount() == 8 && std::string_view(begin.data(), 8) == "XTENSION";
}

}  // namespace

std::vector<FitsHdu> check_fits_structure(const std::filesystem::path& path) {
  FitsStream stream{.file = path.string(), .in = std::ifstream(path, std::ios::binary)};
  if (!stream.in) throw Error({stream.file, "cannot be opened for reading", "", ""});
  stream.bytes = static_cast<long long>(std::filesystem::file_size(path));
  std::vector<FitsHdu> hdus;
  do {
    const long long offset = stream.at;
    hdus.push_back(checked_hdu(read_header(stream, static_cast<int>(hdus.size()) + 1), stream.bytes));
    hdus.back().offset = offset;
    hdus.back().data_offset = stream.at;
    skip_data(stream, hdus.back());
  } while (at_extension(stream));
  return hdus;
}

}  // namespace scatmap
