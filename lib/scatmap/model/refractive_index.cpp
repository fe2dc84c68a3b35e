#include "scatmap/model/refractive_index.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/output_file.h"
#include "scatmap/base/units.h"

namespace scatmap {
namespace {

struct Line {
  std::size_t number = 0;
  std::size_t indent = 0;
  std::string_view text;  // without indent and trailing blanks
};

struct Source {
  const std::string& name;
  std::vector<Line> lines;

  [[noreturn]] void fail(const Line& line, const std::string& problem, const std::string& expected) const {
    throw Error({name + ":" + std::to_string(line.number), problem, "\"" + std::string(line.text) + "\"", expected});
  }
};

// One entry of DATA: a table of (wavelength, n and/or k) rows, or a formula's coefficients.
struct Block {
  std::string_view type;
  Line where;
  std::vector<std::vector<double>> rows;
  std::vector<double> range_um;
  std::vector<double> coefficients;
};

Source split(const std::string& text, const std::string& name) {
  Source source{name, {}};
  std::size_t number = 0;
  for (std::string_view rest = text; !rest.empty();) {
    ++number;
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    while (!line.empty() && (line.back() == ' ' || line.back() == '\r')) line.remove_suffix(1);
    const std::size_t indent = line.find_first_not_of(' ');
    if (indent == std::string_view::npos || line[indent] == '#') continue;
    source.lines.push_back({number, indent, line.substr(indent)});
  }
  return source;
}

std::vector<double> numbers(const Source& source, const Line& line, std::string_view text) {
  std::vector<double> out;
  while (!text.empty()) {
    if (text.front() == ' ') {
      text.remove_prefix(1);
      continue;
    }
    const std::string_view word = text.substr(0, text.find(' '));
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
      source.fail(line, "has something that is not a number", "finite numbers");
    }
    out.push_back(value);
    text.remove_prefix(word.size());
  }
  return out;
}

// The text after "key:", if the line is that key's.
std::optional<std::string_view> value_of(const Line& line, std::string_view key) {
  if (!line.text.starts_with(key) || line.text.substr(key.size()).substr(0, 1) != ":") return std::nullopt;
  const std::string_view rest = line.text.substr(key.size() + 1);
  return rest.substr(std::min(rest.find_first_not_of(' '), rest.size()));
}

void check_row(const Source& source, const Line& line, const Block& block, const std::vector<double>& row) {
  const std::size_t columns = block.type == "tabulated nk" ? 3 : 2;
  if (row.size() != columns) {
    source.fail(line, "has the wrong number of columns", std::to_string(columns) + " numbers");
  }
  if (!(row[0] > 0) || (!block.rows.empty() && row[0] <= block.rows.back()[0])) {
    source.fail(line, "is out of order", "wavelengths that increase from row to row");
  }
  const bool starts_with_n = block.type != "tabulated k";
  if (row[1] < 0 || (starts_with_n && row[1] == 0) || row.back() < 0) {
    source.fail(line, "has an impossible index", "n > 0 and k >= 0");
  }
}

// Rows of the table that starts after lines[at]; returns the line after it.
std::size_t read_rows(const Source& source, std::size_t at, Block& block) {
  const std::size_t key_indent = source.lines[at].indent;
  for (++at; at < source.lines.size() && source.lines[at].indent > key_indent; ++at) {
    const Line& line = source.lines[at];
    const std::vector<double> row = numbers(source, line, line.text);
    check_row(source, line, block, row);
    block.rows.push_back(row);
  }
  return at;
}

std::size_t read_key(const Source& source, std::size_t at, Block& block) {
  const Line& line = source.lines[at];
  const bool table = block.type.starts_with("tabulated");
  if (const auto value = value_of(line, "data"); value && table && block.rows.empty()) {
    if (*value != "|") source.fail(line, "is not understood", "\"data: |\" and the rows below it");
    return read_rows(source, at, block);
  }
  if (const auto value = value_of(line, "wavelength_range"); value && !table && block.range_um.empty()) {
    block.range_um = numbers(source, line, *value);
    const std::vector<double>& r = block.range_um;
    if (r.size() != 2 || !(r[0] > 0 && r[0] < r[1])) source.fail(line, "is not a range", "two increasing numbers > 0");
    return at + 1;
  }
  if (const auto value = value_of(line, "coefficients"); value && !table && block.coefficients.empty()) {
    block.coefficients = numbers(source, line, *value);
    if (block.coefficients.size() % 2 == 0) source.fail(line, "has an even number of coefficients", "an odd number");
    return at + 1;
  }
  source.fail(line, "is not understood here",
              table ? "one \"data: |\" in a table" : "one wavelength_range and one coefficients in a formula");
}

std::size_t read_block(const Source& source, std::size_t at, std::vector<Block>& blocks) {
  constexpr std::array kTypes = {"tabulated nk", "tabulated n", "tabulated k", "formula 1", "formula 2"};
  const Line& head = source.lines[at];
  const auto type = head.text.starts_with("- ") ? value_of({0, 0, head.text.substr(2)}, "type") : std::nullopt;
  if (!type) source.fail(head, "is not understood", "\"- type: ...\"");
  if (std::find(kTypes.begin(), kTypes.end(), *type) == kTypes.end()) {
    source.fail(head, "is a kind of data that is not supported", "tabulated nk, n or k, formula 1 or 2");
  }
  Block block{*type, head, {}, {}, {}};
  for (++at; at < source.lines.size() && source.lines[at].indent > head.indent;) {
    if (source.lines[at].indent != head.indent + 2) source.fail(source.lines[at], "is indented wrongly", {});
    at = read_key(source, at, block);
  }
  const bool whole = block.type.starts_with("tabulated") ? !block.rows.empty()
                                                         : !block.range_um.empty() && !block.coefficients.empty();
  if (!whole) source.fail(head, "has no complete data", {});
  blocks.push_back(std::move(block));
  return at;
}

bool is_text_section(const Line& line) {
  for (const auto* key : {"REFERENCES", "COMMENTS", "CONDITIONS", "PROPERTIES", "SPECS"}) {
    if (value_of(line, key)) return true;
  }
  return false;
}

std::vector<Block> read_blocks(const Source& source) {
  std::vector<Block> blocks;
  for (std::size_t at = 0; at < source.lines.size();) {
    const Line& line = source.lines[at++];
    const bool data = line.indent == 0 && line.text == "DATA:" && blocks.empty();
    if (!data && (line.indent != 0 || !is_text_section(line))) {
      source.fail(line, "is not understood here", "REFERENCES, COMMENTS, CONDITIONS, PROPERTIES, SPECS or one DATA");
    }
    while (at < source.lines.size() && source.lines[at].indent > 0) at = data ? read_block(source, at, blocks) : at + 1;
  }
  if (blocks.empty()) throw Error({source.name, "holds no DATA", {}, "a material file of refractiveindex.info"});
  return blocks;
}

// The wavelength, if the block's data reach it. The way from nm through m to um costs a last bit, which must not push
// a wavelength over the end of the data.
double wavelength_within(const Source& source, const Block& block, double um) {
  constexpr double kRounding = 1e-12;
  const bool table = !block.rows.empty();
  const double first = table ? block.rows.front()[0] : block.range_um[0];
  const double last = table ? block.rows.back()[0] : block.range_um[1];
  if (um >= first * (1 - kRounding) && um <= last * (1 + kRounding)) return std::clamp(um, first, last);
  throw Error({source.name + ":" + std::to_string(block.where.number), "the wavelength is outside the material's data",
               number_text(um) + " um", number_text(first) + " to " + number_text(last) + " um"});
}

double interpolated(const Block& block, std::size_t column, double um) {
  const auto above = std::lower_bound(block.rows.begin(), block.rows.end(), um,
                                      [](const std::vector<double>& row, double x) { return row[0] < x; });
  if ((*above)[0] == um) return (*above)[column];
  const std::vector<double>& low = *(above - 1);
  return std::lerp(low[column], (*above)[column], (um - low[0]) / ((*above)[0] - low[0]));
}

double sellmeier(const Source& source, const Block& block, double um) {
  const std::vector<double>& c = block.coefficients;
  double n2 = 1 + c[0];
  for (std::size_t i = 1; i + 1 < c.size(); i += 2) {
    const double pole_um2 = block.type == "formula 1" ? c[i + 1] * c[i + 1] : c[i + 1];
    n2 += c[i] * um * um / (um * um - pole_um2);
  }
  if (!(n2 > 0 && std::isfinite(n2))) source.fail(block.where, "gives no real index at this wavelength", {});
  return std::sqrt(n2);
}

}  // namespace

std::complex<double> parse_refractive_index(const std::string& text, const std::string& name, double wavelength_m) {
  const Source source = split(text, name);
  std::optional<double> n, k;
  for (const Block& block : read_blocks(source)) {
    const double um = wavelength_within(source, block, wavelength_m / kMetrePerUm);
    const bool gives_n = block.type != "tabulated k";
    const bool gives_k = block.type == "tabulated k" || block.type == "tabulated nk";
    if ((gives_n && n) || (gives_k && k)) source.fail(block.where, "gives the same quantity a second time", {});
    if (gives_n) n = block.rows.empty() ? sellmeier(source, block, um) : interpolated(block, 1, um);
    if (gives_k) k = interpolated(block, block.type == "tabulated k" ? 1 : 2, um);
  }
  if (!n) throw Error({name, "gives no n", {}, "a table or formula of n"});
  return {*n, k.value_or(0)};
}

std::complex<double> read_refractive_index(const std::filesystem::path& path, double wavelength_m) {
  return parse_refractive_index(read_text_file(path), path.string(), wavelength_m);
}

}  // namespace scatmap
