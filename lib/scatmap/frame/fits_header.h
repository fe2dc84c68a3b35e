#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace scatmap {

/// Bytes of one header card.
inline constexpr int kFitsCardBytes = 80;

/// One card of a FITS header (FITS standard 4.0, section 4.1).
struct FitsCard {
  std::string key;         ///< without trailing blanks
  std::string value;       ///< without quotes, trailing blanks and comment; empty when undefined
  bool has_value = false;  ///< "= " stands in columns 9 and 10
  bool quoted = false;     ///< the value is a string
  int number = 0;          ///< 1 is the first card of its header
};

/// The cards of one HDU, with strict reading of their values: a key that is there must mean what it is asked for.
class FitsHeader {
 public:
  /// @param file name for messages; hdu: 1 is the primary
  FitsHeader(std::string file, int hdu) : file_(std::move(file)), hdu_(hdu) {}

  /// @param text one card, kFitsCardBytes long
  void add(std::string_view text);

  const std::vector<FitsCard>& cards() const { return cards_; }
  int hdu() const { return hdu_; }
  const std::string& file() const { return file_; }

  /// @return the card of a key, nullptr when there is none. @throws Error if it stands twice with different values
  const FitsCard* find(std::string_view key) const;

  /// @return the value of a key, nothing when there is no such card.
  /// @throws Error if the value is of another type, malformed or not finite
  std::optional<long long> integer(std::string_view key) const;
  std::optional<double> number(std::string_view key) const;
  std::optional<std::string> text(std::string_view key) const;
  std::optional<bool> logical(std::string_view key) const;

  /// @return "FILE: HDU 1, card 4 (NAXIS1)"
  std::string where(const FitsCard& card) const;
  /// @return "FILE: HDU 1"
  std::string where() const;

 private:
  std::string file_;
  int hdu_;
  std::vector<FitsCard> cards_;
};

}  // namespace scatmap
