#include "scatmap/base/error.h"

#include <utility>

#include "scatmap/base/provenance.h"

namespace scatmap {
namespace {

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

// One line of valid UTF-8 whatever the input held: control characters of a hostile file must not reach a terminal.
std::string printable(const std::string& bytes) {
  const std::string text = utf8_text(bytes);
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto u = static_cast<unsigned char>(text[i]);
    const bool c1 = u == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0;
    if (c1) ++i;
    out += u < 0x20 || u == 0x7f || c1 ? '?' : text[i];
  }
  return out;
}

// The start of a long value, cut between characters.
std::string shortened(const std::string& text) {
  std::size_t end = kLongestGot;
  if (text.size() <= end) return text;
  while (end > 0 && is_continuation(text[end])) --end;
  return text.substr(0, end) + "...";
}

std::string message(const ErrorDetail& d) {
  std::string text = d.where.empty() ? d.problem : d.where + ": " + d.problem;
  if (!d.got.empty()) text += ", got " + shortened(d.got);
  if (!d.expected.empty()) text += ", expected " + d.expected;
  return printable(text);
}

}  // namespace

Error::Error(ErrorDetail detail) : std::runtime_error(message(detail)), detail_(std::move(detail)) {}

Error with_context(const std::string& context, const Error& error) {
  ErrorDetail detail = error.detail();
  detail.where = detail.where.empty() ? context : context + ": " + detail.where;
  return Error(std::move(detail));
}

}  // namespace scatmap
