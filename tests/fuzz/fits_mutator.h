#pragma once
// Included by targets that read FITS: half of the mutations change one header card instead of bytes anywhere. In a file
// of cards and zeros, bytes changed at random mostly damage what no reader looks at.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace fuzz {

inline constexpr std::array kKeys{"SIMPLE  ", "XTENSION", "BITPIX  ", "NAXIS   ", "NAXIS1  ", "NAXIS2  ", "NAXIS3  ",
                                  "PCOUNT  ", "GCOUNT  ", "GROUPS  ", "TFIELDS ", "TFORM1  ", "TFORM2  ", "TTYPE1  ",
                                  "EXTNAME ", "BZERO   ", "BSCALE  ", "BLANK   ", "ZIMAGE  ", "ZCMPTYPE", "THEAP   ",
                                  "END     ", "CONTINUE", "EXPTIME ", "EGAIN   ", "ROWORDER", "INHERIT ", "TNULL1  ",
                                  "TSCAL1  ", "TZERO1  ", "TDIM1   ", "STAGERAD", "WAVELEN ", "DISTRIB ", "HALFWID "};
inline constexpr std::array kValues{"T",
                                    "F",
                                    "0",
                                    "1",
                                    "-1",
                                    "2",
                                    "3",
                                    "8",
                                    "16",
                                    "32",
                                    "-32",
                                    "-64",
                                    "64",
                                    "999",
                                    "32768",
                                    "2147483647",
                                    "2147483648",
                                    "-2147483648",
                                    "9223372036854775807",
                                    "1E308",
                                    "1E-320",
                                    "NaN",
                                    "'IMAGE   '",
                                    "'BINTABLE'",
                                    "'TABLE   '",
                                    "'1D      '",
                                    "'0A      '",
                                    "'100000A '",
                                    "'1PD(9)  '",
                                    "'1QA(3)  '",
                                    "'0D      '",
                                    "'A&'",
                                    "'''",
                                    "'BRDF    '",
                                    "'MASK    '",
                                    "'U_RANDOM'",
                                    "'COMMON  '",
                                    "'INSTRUMENT'",
                                    "'normal  '",
                                    "/",
                                    ""};

inline void change_card(std::uint8_t* card, std::mt19937& random) {
  const auto one_of = [&](const auto& list) { return list[random() % list.size()]; };
  const std::string value = one_of(kValues);
  if (random() % 4 == 0) std::memcpy(card, one_of(kKeys), 8);
  if (random() % 8 == 0) {
    std::memset(card, ' ', 80);
    std::memcpy(card, "END", 3);
    return;
  }
  std::memset(card + 8, ' ', 72);
  card[8] = '=';
  const std::size_t at = value.starts_with('\'') || value.size() > 20 ? 10 : 30 - value.size();
  std::memcpy(card + at, value.data(), value.size());
}

// Where headers are, cards hold no control characters.
inline bool is_card(const std::uint8_t* card) {
  return std::all_of(card, card + 80, [](std::uint8_t c) { return c >= 0x20 && c < 0x7f; });
}

}  // namespace fuzz

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  std::mt19937 random(seed);
  if (size < 2880 || random() % 2 == 0) return LLVMFuzzerMutate(data, size, max_size);
  for (int attempt = 0; attempt < 20; ++attempt) {
    const std::size_t block = random() % (size / 2880) * 2880;
    std::uint8_t* card = data + block + random() % 36 * 80;
    if (!fuzz::is_card(card)) continue;
    if (random() % 8 == 0) {  // two cards change places
      std::uint8_t* other = data + block + random() % 36 * 80;
      std::swap_ranges(card, card + 80, other);
    } else {
      fuzz::change_card(card, random);
    }
    return size;
  }
  return LLVMFuzzerMutate(data, size, max_size);
}
