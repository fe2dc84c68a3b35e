#include "scatmap/base/error.h"

#include <utility>

namespace scatmap {
namespace {

// One line whatever the input held: control characters of a hostile file must not reach a terminal.
std::string printable(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    out += (u < 0x20 || u == 0x7f) ? '?' : c;
  }
  return out;
}

std::string message(const ErrorDetail& d) {
  std::string text = d.where.empty() ? d.problem : d.where + ": " + d.problem;
  if (!d.got.empty()) text += ", got " + d.got;
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
