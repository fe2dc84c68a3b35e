#include "scatmap/frame/fits_header.h"

#include <charconv>
#include <cmath>

#include "scatmap/base/error.h"

namespace scatmap {
namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

// The string between quotes, two quotes standing for one; nothing when the closing quote is missing.
std::optional<std::string> quoted_text(std::string_view text) {
  std::string out;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] != '\'') {
      out += text[i];
    } else if (i + 1 < text.size() && text[i + 1] == '\'') {
      out += text[i++];
    } else {
      while (!out.empty() && out.back() == ' ') out.pop_back();
      return out;
    }
  }
  return std::nullopt;
}

template <class T>
std::optional<T> parsed(std::string_view text) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return std::nullopt;
  }
  T value{};
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<double> parsed_number(std::string text) {
  // from_chars also takes "nan" and "inf", which FITS does not have; FITS has D for the exponent, which it does not
  // take.
  if (text.find_first_not_of("0123456789+-.EDed") != std::string::npos) return std::nullopt;
  for (char& c : text) {
    if (c == 'D' || c == 'd') c = 'E';
  }
  const auto value = parsed<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string shown(const FitsCard& card) {
  if (!card.has_value || (card.value.empty() && !card.quoted)) return "no value";
  return card.quoted ? "'" + card.value + "'" : card.value;
}

}  // namespace

void FitsHeader::add(std::string_view text) {
  FitsCard card;
  card.number = static_cast<int>(cards_.size()) + 1;
  card.key = std::string(trimmed(text.substr(0, 8)));
  card.has_value = text.substr(8, 2) == "= ";
  if (card.has_value) {
    const std::string_view rest = trimmed(text.substr(10));
    const auto string = rest.starts_with('\'') ? quoted_text(rest) : std::nullopt;
    card.quoted = string.has_value();
    card.value = string ? *string : std::string(trimmed(rest.substr(0, rest.find('/'))));
  }
  cards_.push_back(std::move(card));
}

const FitsCard* FitsHeader::find(std::string_view key) const {
  const FitsCard* found = nullptr;
  for (const FitsCard& card : cards_) {
    if (card.key != key) continue;
    if (found == nullptr) {
      found = &card;
    } else if (found->value != card.value || found->quoted != card.quoted) {
      throw Error({where(card), "stands twice with different values", shown(*found) + " and " + shown(card), ""});
    }
  }
  return found;
}

std::optional<long long> FitsHeader::integer(std::string_view key) const {
  const FitsCard* card = find(key);
  if (card == nullptr) return std::nullopt;
  const auto value = card->quoted ? std::nullopt : parsed<long long>(card->value);
  if (!value) throw Error({where(*card), "is not an integer", shown(*card), ""});
  return value;
}

std::optional<double> FitsHeader::number(std::string_view key) const {
  const FitsCard* card = find(key);
  if (card == nullptr) return std::nullopt;
  const auto value = card->quoted ? std::nullopt : parsed_number(card->value);
  if (!value) throw Error({where(*card), "is not a number", shown(*card), "a finite number"});
  return value;
}

std::optional<std::string> FitsHeader::text(std::string_view key) const {
  const FitsCard* card = find(key);
  if (card == nullptr) return std::nullopt;
  if (!card->quoted) throw Error({where(*card), "is not a string", shown(*card), "text in single quotes"});
  return card->value;
}

std::optional<bool> FitsHeader::logical(std::string_view key) const {
  const FitsCard* card = find(key);
  if (card == nullptr) return std::nullopt;
  if (card->quoted || (card->value != "T" && card->value != "F")) {
    throw Error({where(*card), "is not a logical value", shown(*card), "T or F"});
  }
  return card->value == "T";
}

std::string FitsHeader::where(const FitsCard& card) const {
  return where() + ", card " + std::to_string(card.number) + " (" + card.key + ")";
}

std::string FitsHeader::where() const { return file_ + ": HDU " + std::to_string(hdu_); }

}  // namespace scatmap
