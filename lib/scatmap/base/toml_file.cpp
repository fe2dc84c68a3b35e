#include "scatmap/base/toml_file.h"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"

namespace scatmap {

struct TomlTable::Document {
  toml::table root;
  std::string name;
  std::filesystem::path folder;
};

struct TomlTable::Node {
  const toml::table* table = nullptr;
  std::string prefix;  // dotted name of this table, with a trailing dot, or empty
  std::set<std::string, std::less<>> asked;
  std::vector<std::shared_ptr<Node>> children;
};

namespace {

std::string at_line(const std::string& file, const toml::node* node) {
  if (node == nullptr || node->source().begin.line == 0) return file;
  return file + ":" + std::to_string(node->source().begin.line);
}

// Letters to change, put in or leave out to make one word the other (Levenshtein, Sov. Phys. Dokl. 10, 707 (1966)).
std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t before = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = before + (a[i - 1] == b[j - 1] ? 0 : 1);
      before = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, changed}));
    }
  }
  return row.back();
}

// Whether one may be a slip of the other: two letters of a word that has more.
bool alike(const std::string& a, const std::string& b) {
  constexpr std::size_t kSlip = 2, kLongest = 100;
  return a.size() > 2 * kSlip && std::max(a.size(), b.size()) <= kLongest && edits(a, b) <= kSlip;
}

std::string shown(double value) {
  std::ostringstream out;
  out.precision(17);
  out << value;
  return out.str();
}

std::string described(const NumberRange& range) {
  constexpr double kMax = std::numeric_limits<double>::max();
  if (range.minimum == -kMax && range.maximum == kMax) return "a finite number";
  std::string text = "a number";
  if (range.minimum > -kMax) text += (range.exclude_minimum ? " > " : " >= ") + shown(range.minimum);
  if (range.maximum < kMax)
    text += (range.minimum > -kMax ? std::string(" and <= ") : std::string(" <= ")) + shown(range.maximum);
  return text;
}

bool inside(double v, const NumberRange& r) {
  return std::isfinite(v) && v <= r.maximum && (r.exclude_minimum ? v > r.minimum : v >= r.minimum);
}

std::string type_name(const toml::node& node) {
  std::ostringstream out;
  out << node.type();
  const std::string name = out.str();
  return (name == "integer" || name == "array" ? "an " : "a ") + name;
}

double checked_number(const toml::node& node, const std::string& where, const NumberRange& range) {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value) throw Error({where, "has the wrong type", type_name(node), described(range)});
  if (!inside(*value, range)) throw Error({where, "is out of range", shown(*value), described(range)});
  return *value;
}

// Where the string that begins at `at` ends: behind its closing quotes, or where it cannot go on.
std::size_t end_of_string(const std::string& text, std::size_t at) {
  const char quote = text[at];
  const std::string triple(3, quote);
  const bool multi_line = text.compare(at, 3, triple) == 0;
  for (at += multi_line ? 3 : 1; at < text.size(); ++at) {
    if (text[at] == '\\' && quote == '"') {
      ++at;
    } else if (multi_line ? text.compare(at, 3, triple) == 0 : text[at] == quote) {
      return at + (multi_line ? 3 : 1);
    } else if (text[at] == '\n' && !multi_line) {
      return at;
    }
  }
  return text.size();
}

// The wrong file by mistake: its name helps, the line at which it stops being TOML does not.
void refuse_other_formats(std::string_view text, const std::string& name) {
  constexpr std::array<std::pair<std::string_view, const char*>, 5> kFormats{{
      {"SIMPLE  =", "is a FITS file, not TOML"},
      {"\x89PNG", "is a PNG image, not TOML"},
      {{"II*\0", 4}, "is a TIFF image, not TOML"},
      {{"MM\0*", 4}, "is a TIFF image, not TOML"},
      {"v/1\x01", "is an OpenEXR image, not TOML"},
  }};
  for (const auto& [magic, problem] : kFormats) {
    if (text.starts_with(magic)) throw Error({name, problem, {}, {}});
  }
  if (text.find('\0') != std::string_view::npos) throw Error({name, "is no text file", {}, "TOML"});
}

// A dotted key of a million parts makes a million tables in each other, and toml++ walks them by recursion: the stack
// would overflow.
void refuse_long_keys(const std::string& text, const std::string& name) {
  constexpr int kMostDots = 16;
  int dots = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      i = end_of_string(text, i);
      continue;
    }
    if (c == '.' && ++dots > kMostDots) {
      const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(i), '\n');
      throw Error({name + ":" + std::to_string(line), "has a key of too many parts", {}, {}});
    }
    if (std::string_view("=,[]{}\n#").find(c) != std::string_view::npos) dots = 0;
    i = c == '#' ? std::min(text.find('\n', i), text.size()) : i + 1;
  }
}

}  // namespace

TomlTable::TomlTable(std::shared_ptr<Document> document, std::shared_ptr<Node> node)
    : document_(std::move(document)), node_(std::move(node)) {}

TomlTable TomlTable::parse(const std::string& text, const std::string& name) {
  auto document = std::make_shared<Document>();
  document->name = name;
  document->folder = std::filesystem::path(name).parent_path();
  refuse_other_formats(text, name);
  refuse_long_keys(text, name);
  try {
    document->root = toml::parse(text, name);
  } catch (const toml::parse_error& e) {
    throw Error({name + ":" + std::to_string(e.source().begin.line),
                 "is not valid TOML: " + std::string(e.description()),
                 {},
                 {}});
  }
  auto node = std::make_shared<Node>();
  node->table = &document->root;
  return {std::move(document), std::move(node)};
}

TomlTable TomlTable::read(const std::filesystem::path& path) { return parse(read_text_file(path), path.string()); }

std::string TomlTable::where(const std::string& key) const {
  const toml::node* found = node_->table->get(key);
  return at_line(document_->name, found != nullptr ? found : node_->table) + ": " + node_->prefix + key;
}

Error TomlTable::missing(const std::string& key, const std::string& expected) const {
  for (const auto& [name, node] : *node_->table) {
    const std::string other(name.str());
    if (alike(key, other))
      return Error(
          {where(key), "is missing", other + " in line " + std::to_string(node.source().begin.line), expected});
  }
  return Error({where(key), "is missing", {}, expected});
}

std::filesystem::path TomlTable::resolve(const std::string& path) const { return document_->folder / path; }

bool TomlTable::has(const std::string& key) const { return node_->table->contains(key); }

double TomlTable::number(const std::string& key, const NumberRange& range) const {
  const auto value = optional_number(key, range);
  if (!value) throw missing(key, described(range));
  return *value;
}

std::optional<double> TomlTable::optional_number(const std::string& key, const NumberRange& range) const {
  node_->asked.insert(key);
  const toml::node* found = node_->table->get(key);
  if (found == nullptr) return std::nullopt;
  return checked_number(*found, where(key), range);
}

double TomlTable::number_or(const std::string& key, double fallback, const NumberRange& range) const {
  return optional_number(key, range).value_or(fallback);
}

std::vector<double> TomlTable::numbers(const std::string& key, std::size_t count, const NumberRange& range) const {
  node_->asked.insert(key);
  const toml::node* found = node_->table->get(key);
  const std::string wanted = count == 0 ? "an array of numbers" : "an array of " + std::to_string(count) + " numbers";
  if (found == nullptr) throw missing(key, wanted);
  const toml::array* array = found->as_array();
  if (array == nullptr) throw Error({where(key), "has the wrong type", type_name(*found), wanted});
  if (count != 0 && array->size() != count) {
    throw Error({where(key), "has the wrong length", std::to_string(array->size()) + " elements", wanted});
  }
  std::vector<double> out;
  for (const toml::node& element : *array) out.push_back(checked_number(element, where(key), range));
  return out;
}

int TomlTable::integer(const std::string& key, int minimum, int maximum) const {
  node_->asked.insert(key);
  const std::string wanted = "an integer from " + std::to_string(minimum) + " to " + std::to_string(maximum);
  const toml::node* found = node_->table->get(key);
  if (found == nullptr) throw missing(key, wanted);
  const auto value = found->is_integer() ? found->value<std::int64_t>() : std::nullopt;
  if (!value) throw Error({where(key), "has the wrong type", type_name(*found), wanted});
  if (*value < minimum || *value > maximum)
    throw Error({where(key), "is out of range", std::to_string(*value), wanted});
  return static_cast<int>(*value);
}

bool TomlTable::boolean_or(const std::string& key, bool fallback) const {
  node_->asked.insert(key);
  const toml::node* found = node_->table->get(key);
  if (found == nullptr) return fallback;
  const auto value = found->value_exact<bool>();
  if (!value) throw Error({where(key), "has the wrong type", type_name(*found), "true or false"});
  return *value;
}

std::string TomlTable::string(const std::string& key) const {
  const auto value = optional_string(key);
  if (!value) throw missing(key, "a string");
  return *value;
}

std::optional<std::string> TomlTable::optional_string(const std::string& key) const {
  node_->asked.insert(key);
  const toml::node* found = node_->table->get(key);
  if (found == nullptr) return std::nullopt;
  const auto value = found->value_exact<std::string>();
  if (!value) throw Error({where(key), "has the wrong type", type_name(*found), "a string"});
  if (value->empty()) throw Error({where(key), "is empty", {}, "a string"});
  return value;
}

std::string TomlTable::choice(const std::string& key, const std::vector<std::string>& choices) const {
  const std::string value = optional_string(key).value_or(choices.front());
  if (std::find(choices.begin(), choices.end(), value) != choices.end()) return value;
  std::string wanted = "one of";
  for (const std::string& c : choices) wanted += " \"" + c + "\"";
  throw Error({where(key), "is not known", "\"" + value + "\"", wanted});
}

std::vector<std::string> TomlTable::strings(const std::string& key) const {
  if (!has(key)) throw missing(key, "an array of strings");
  return strings_or_empty(key);
}

std::vector<std::string> TomlTable::strings_or_empty(const std::string& key) const {
  node_->asked.insert(key);
  const toml::node* found = node_->table->get(key);
  if (found == nullptr) return {};
  const toml::array* array = found->as_array();
  if (array == nullptr) throw Error({where(key), "has the wrong type", type_name(*found), "an array of strings"});
  std::vector<std::string> out;
  for (const toml::node& element : *array) {
    const auto value = element.value_exact<std::string>();
    if (!value || value->empty())
      throw Error({where(key), "has an element of the wrong type", type_name(element), "strings"});
    out.push_back(*value);
  }
  return out;
}

std::vector<std::vector<double>> TomlTable::matrix(const std::string& key) const {
  node_->asked.insert(key);
  const toml::node* found = node_->table->get(key);
  if (found == nullptr) throw missing(key, "an array of rows of numbers");
  const toml::array* rows = found->as_array();
  if (rows == nullptr)
    throw Error({where(key), "has the wrong type", type_name(*found), "an array of rows of numbers"});
  std::vector<std::vector<double>> out;
  for (const toml::node& row : *rows) {
    const toml::array* array = row.as_array();
    if (array == nullptr) throw Error({where(key), "has a row of the wrong type", type_name(row), "numbers"});
    out.emplace_back();
    for (const toml::node& element : *array) out.back().push_back(checked_number(element, where(key), kAnyNumber));
  }
  return out;
}

TomlTable TomlTable::table(const std::string& key) const {
  const auto found = optional_table(key);
  if (!found) throw missing(key, "a table [" + node_->prefix + key + "]");
  return *found;
}

std::optional<TomlTable> TomlTable::optional_table(const std::string& key) const {
  node_->asked.insert(key);
  const toml::node* found = node_->table->get(key);
  if (found == nullptr) return std::nullopt;
  if (!found->is_table()) throw Error({where(key), "has the wrong type", type_name(*found), "a table"});
  for (const auto& child : node_->children) {
    if (child->table == found->as_table()) return TomlTable(document_, child);
  }
  auto child = std::make_shared<Node>();
  child->table = found->as_table();
  child->prefix = node_->prefix + key + ".";
  node_->children.push_back(child);
  return TomlTable(document_, child);
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) const {
  node_->asked.insert(key);
  const toml::node* found = node_->table->get(key);
  if (found == nullptr) return {};
  const toml::array* array = found->as_array();
  if (array == nullptr)
    throw Error({where(key), "has the wrong type", type_name(*found), "tables [[" + node_->prefix + key + "]]"});
  std::vector<TomlTable> out;
  for (const toml::node& element : *array) {
    if (!element.is_table())
      throw Error({where(key), "has an element of the wrong type", type_name(element), "tables"});
    auto child = std::make_shared<Node>();
    child->table = element.as_table();
    child->prefix = node_->prefix + key + "." + std::to_string(out.size()) + ".";
    node_->children.push_back(child);
    out.push_back(TomlTable(document_, child));
  }
  return out;
}

std::vector<std::string> TomlTable::table_names() const {
  std::vector<std::pair<std::size_t, std::string>> found;
  for (const auto& [key, value] : *node_->table) {
    if (value.is_table()) found.emplace_back(value.source().begin.line, std::string(key.str()));
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> names;
  for (auto& [line, name] : found) names.push_back(std::move(name));
  return names;
}

void TomlTable::reject_unknown_keys() const {
  for (const auto& [key, value] : *node_->table) {
    if (!node_->asked.contains(key.str())) throw Error({where(std::string(key.str())), "is not a known key", {}, {}});
  }
  for (const auto& child : node_->children) TomlTable(document_, child).reject_unknown_keys();
}

}  // namespace scatmap
