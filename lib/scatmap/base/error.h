#pragma once
#include <cstddef>
#include <stdexcept>
#include <string>

namespace scatmap {

/// What went wrong with an input, in the words a user can act on.
/// Empty fields are left out of the message: "WHERE: PROBLEM, got GOT, expected EXPECTED". The message is one line of
/// valid UTF-8: control characters and stray bytes become '?', and a long `got` is cut.
struct ErrorDetail {
  std::string where;     ///< file, and line, key, HDU or option where known: "scene.toml:12: beam.elevation_deg"
  std::string problem;   ///< one clause, no full stop
  std::string got;       ///< the offending value, if there is one
  std::string expected;  ///< what would have been accepted
};

/// Messages show at most so many bytes of `got`.
inline constexpr std::size_t kLongestGot = 60;

/// The one exception of scatmap. Constructors and readers throw it; per-pixel mathematics never throws
/// (NaN in, NaN out, and a mask bit). Only `main` catches it: exit status 1.
class Error : public std::runtime_error {
 public:
  explicit Error(ErrorDetail detail);
  const ErrorDetail& detail() const { return detail_; }

 private:
  ErrorDetail detail_;
};

/// The same error seen from further out: `context` stands before its place ("measurement.toml: signature: is
/// saturated").
Error with_context(const std::string& context, const Error& error);

}  // namespace scatmap
