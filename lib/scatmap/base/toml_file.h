#pragma once
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scatmap/base/error.h"

namespace scatmap {

/// What a number must satisfy; NaN and infinities never do.
struct NumberRange {
  double minimum = -std::numeric_limits<double>::max();
  double maximum = std::numeric_limits<double>::max();
  bool exclude_minimum = false;  ///< greater than the minimum, not equal
};
inline constexpr NumberRange kAnyNumber{};
inline constexpr NumberRange kPositive{0, std::numeric_limits<double>::max(), true};
inline constexpr NumberRange kNotNegative{0, std::numeric_limits<double>::max(), false};

/// One table of a TOML file, read strictly: every key must be asked for, have the right type and lie in its range.
/// Errors name file, line and dotted key ("bench.toml:7: detector.distance_mm"). Copies share the record of keys asked
/// for.
class TomlTable {
 public:
  /// Parses a whole file. @throws Error with line and column of a syntax error
  static TomlTable read(const std::filesystem::path& path);
  /// The same from text; `name` stands for the file in messages.
  static TomlTable parse(const std::string& text, const std::string& name);

  bool has(const std::string& key) const;
  double number(const std::string& key, const NumberRange& range = kAnyNumber) const;
  std::optional<double> optional_number(const std::string& key, const NumberRange& range = kAnyNumber) const;
  double number_or(const std::string& key, double fallback, const NumberRange& range = kAnyNumber) const;
  /// An array of exactly `count` numbers; any count when 0.
  std::vector<double> numbers(const std::string& key, std::size_t count, const NumberRange& range = kAnyNumber) const;
  int integer(const std::string& key, int minimum, int maximum) const;
  bool boolean_or(const std::string& key, bool fallback) const;
  std::string string(const std::string& key) const;
  std::optional<std::string> optional_string(const std::string& key) const;
  /// One of `choices`; the first is the default when the key is absent.
  std::string choice(const std::string& key, const std::vector<std::string>& choices) const;
  std::vector<std::string> strings(const std::string& key) const;
  std::vector<std::string> strings_or_empty(const std::string& key) const;
  std::vector<std::vector<double>> matrix(const std::string& key) const;

  TomlTable table(const std::string& key) const;
  std::optional<TomlTable> optional_table(const std::string& key) const;
  /// The tables of [[key]], in order; empty when absent.
  std::vector<TomlTable> tables(const std::string& key) const;
  /// Names of all sub-tables of this table, in file order ([filters.NAME]).
  std::vector<std::string> table_names() const;

  /// "FILE:LINE: dotted.key", for errors about a key's meaning. The line is that of the key, or of this table.
  std::string where(const std::string& key) const;
  /// A path in the file is relative to the file's own folder.
  std::filesystem::path resolve(const std::string& path) const;
  /// @throws Error for the first key, here or in a sub-table, that nothing asked for
  void reject_unknown_keys() const;

 private:
  struct Document;
  struct Node;
  TomlTable(std::shared_ptr<Document> document, std::shared_ptr<Node> node);
  /// Names a key that is there and may be meant.
  Error missing(const std::string& key, const std::string& expected) const;
  std::shared_ptr<Document> document_;
  std::shared_ptr<Node> node_;
};

}  // namespace scatmap
