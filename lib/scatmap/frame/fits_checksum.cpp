#include "scatmap/frame/fits_checksum.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/frame/fits_sum.h"

namespace scatmap {
namespace {

std::uint32_t sum_in_file(const std::filesystem::path& path, long long offset, long long bytes) {
  std::ifstream in(path, std::ios::binary);
  in.seekg(offset);
  constexpr long long kPart = 360 * kFitsBlockBytes;  // a megabyte
  std::vector<char> part(static_cast<std::size_t>(std::min(bytes, kPart)));
  std::uint64_t sum = 0;
  for (long long done = 0; done < bytes; done += kPart) {
    const auto count = static_cast<std::size_t>(std::min(kPart, bytes - done));
    if (!in.read(part.data(), static_cast<std::streamsize>(count)))
      throw Error({path.string(), "became shorter while it was read", {}, {}});
    sum += fits_sum_of_bytes({part.data(), count});
  }
  return fits_sum_folded(sum);
}

// An empty value is one that is not known (section 4.4.2.7).
const FitsCard* stated(const FitsHdu& hdu, const char* key) {
  const FitsCard* card = hdu.header.find(key);
  return card == nullptr || card->value.empty() ? nullptr : card;
}

std::uint32_t data_sum(const std::filesystem::path& path, const FitsHdu& hdu) {
  return sum_in_file(path, hdu.data_offset, hdu.padded_bytes());
}

void require_data_sum(const FitsHdu& hdu, const FitsCard& card, std::uint32_t sum) {
  const std::string text = card.value.substr(card.value.find_first_not_of(' '));  // CFITSIO fills from the left
  if (text == std::to_string(sum)) return;
  throw Error({hdu.header.where(card), "is not the sum of the data: they are damaged, or were edited", text,
               std::to_string(sum) + ", or no DATASUM and CHECKSUM"});
}

}  // namespace

void require_fits_data_sum(const std::filesystem::path& path, const FitsHdu& hdu) {
  if (const FitsCard* card = stated(hdu, "DATASUM")) require_data_sum(hdu, *card, data_sum(path, hdu));
}

void require_fits_sums(const std::filesystem::path& path, const FitsHdu& hdu) {
  const FitsCard *of_data = stated(hdu, "DATASUM"), *of_all = stated(hdu, "CHECKSUM");
  if (of_data == nullptr && of_all == nullptr) return;
  const std::uint32_t sum = data_sum(path, hdu);
  if (of_data != nullptr) require_data_sum(hdu, *of_data, sum);
  if (of_all == nullptr) return;
  constexpr std::uint32_t kMinusZero = 0xffffffff;
  const std::uint64_t header = sum_in_file(path, hdu.offset, hdu.data_offset - hdu.offset);
  if (fits_sum_folded(header + sum) == kMinusZero) return;
  throw Error({hdu.header.where(*of_all),
               "is not that of header and data: one is damaged, or was edited",
               {},
               "sums as written, or no DATASUM and CHECKSUM"});
}

}  // namespace scatmap
