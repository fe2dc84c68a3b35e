#include "scatmap/angles/lens_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/output_file.h"

namespace scatmap {
namespace {

constexpr std::size_t kLargestFile_bytes = std::size_t{256} << 20;  // optimization_inputs are megabytes

// The part of Python's literals that mrcal writes: a dictionary of strings, numbers and nested lists.
class Literals {
 public:
  Literals(const std::string& text, const std::string& name) : rest_(text), name_(name) {}

  [[noreturn]] void fail(const std::string& problem, const std::string& got, const std::string& expected) const {
    throw Error({name_ + ":" + std::to_string(line_), problem, got, expected});
  }
  // The next character that is neither blank nor in a comment; 0 at the end.
  char peek() {
    for (;; take()) {
      if (rest_.empty()) return '\0';
      if (rest_.front() == '#') {
        while (!rest_.empty() && rest_.front() != '\n') take();
        if (rest_.empty()) return '\0';
      }
      if (std::string_view(" \t\r\n").find(rest_.front()) == std::string_view::npos) return rest_.front();
    }
  }
  void expect(char wanted) {
    if (peek() != wanted) fail("is no camera model", shown(), std::string("'") + wanted + "'");
    take();
  }
  bool accept(char wanted) {
    if (peek() != wanted) return false;
    take();
    return true;
  }
  std::string string() {
    if (peek() == 'b' || peek() == 'u') take();
    const char quote = peek();
    if (quote != '\'' && quote != '"') fail("is no camera model", shown(), "a string in quotes");
    take();
    std::string out;
    while (!rest_.empty() && rest_.front() != quote) {
      if (rest_.front() == '\n') fail("has a string without end", {}, {});
      if (rest_.front() == '\\') out += take();
      if (!rest_.empty()) out += take();
    }
    if (rest_.empty()) fail("has a string without end", {}, {});
    take();
    return out;
  }
  std::string_view word() {
    peek();
    const std::string_view out = rest_.substr(0, std::min(rest_.find_first_of(" \t\r\n,:]})#"), rest_.size()));
    rest_.remove_prefix(out.size());
    return out;
  }
  double number() {
    std::string_view text = word();
    if (text.starts_with('+')) text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc() && end == text.data() + text.size() && std::isfinite(value)) return value;
    fail("has something that is not a number", "'" + std::string(text.substr(0, 40)) + "'", "finite numbers");
  }
  std::vector<double> numbers() {
    std::vector<double> out;
    const char close = open_list();
    while (!accept(close)) {
      out.push_back(number());
      if (peek() != close) expect(',');
    }
    return out;
  }
  void skip_value(int depth = 0) {
    constexpr int kDeepest = 16;
    if (depth > kDeepest) fail("is nested too deep", {}, "a camera model");
    const char c = peek();
    if (c == '[' || c == '(') {
      const char close = open_list();
      while (!accept(close)) {
        skip_value(depth + 1);
        if (peek() != close) expect(',');
      }
    } else if (c == '\'' || c == '"' || (c == 'b' && rest_.size() > 1 && (rest_[1] == '\'' || rest_[1] == '"'))) {
      string();
    } else if (word().empty()) {
      fail("is no camera model", shown(), "a value");
    }
  }

 private:
  char take() {
    const char c = rest_.front();
    if (c == '\n') ++line_;
    rest_.remove_prefix(1);
    return c;
  }
  char open_list() {
    if (accept('(')) return ')';
    expect('[');
    return ']';
  }
  std::string shown() const { return rest_.empty() ? "the end" : "'" + std::string(rest_.substr(0, 1)) + "'"; }

  std::string_view rest_;
  const std::string& name_;
  int line_ = 1;
};

std::optional<double> number_in(std::string_view text, double least, double most) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= least && value <= most))
    return std::nullopt;
  return value;
}

// "_Nx=30" at the front of the text; what follows stays.
std::optional<double> setting(std::string_view& text, std::string_view key, double least, double most) {
  if (!text.starts_with(key)) return std::nullopt;
  text.remove_prefix(key.size());
  const std::string_view value = text.substr(0, std::min(text.find('_'), text.size()));
  text.remove_prefix(value.size());
  return number_in(value, least, most);
}

// Number of intrinsics of a lens model of mrcal 2.2; none for a name it does not have.
std::optional<std::size_t> intrinsics_of(std::string_view model) {
  struct Plain {
    std::string_view name;
    std::size_t intrinsics;
  };
  constexpr std::array kPlain{Plain{"PINHOLE", 4},  Plain{"STEREOGRAPHIC", 4}, Plain{"LONLAT", 4},
                              Plain{"LATLON", 4},   Plain{"OPENCV4", 8},       Plain{"OPENCV5", 9},
                              Plain{"OPENCV8", 12}, Plain{"OPENCV12", 16},     Plain{"CAHVOR", 9}};
  if (!model.starts_with("LENSMODEL_")) return std::nullopt;
  model.remove_prefix(10);
  for (const Plain& p : kPlain) {
    if (model == p.name) return p.intrinsics;
  }
  if (std::string_view rest = model; rest.starts_with("CAHVORE")) {
    rest.remove_prefix(7);
    const auto linearity = setting(rest, "_linearity=", 0, 1);
    return linearity && rest.empty() ? std::optional<std::size_t>(12) : std::nullopt;
  }
  constexpr std::string_view kSplined = "SPLINED_STEREOGRAPHIC";
  if (!model.starts_with(kSplined)) return std::nullopt;
  model.remove_prefix(kSplined.size());
  constexpr double kMostKnots = 500;
  const auto order = setting(model, "_order=", 2, 3);
  const auto nx = setting(model, "_Nx=", 4, kMostKnots), ny = setting(model, "_Ny=", 4, kMostKnots);
  const auto fov = setting(model, "_fov_x_deg=", 1, 360);
  const auto whole = [](const std::optional<double>& v) { return v && *v == std::floor(*v); };
  if (!whole(order) || !whole(nx) || !whole(ny) || !whole(fov) || !model.empty()) return std::nullopt;
  return 4 + 2 * static_cast<std::size_t>(*nx) * static_cast<std::size_t>(*ny);
}

void read_size(Literals& in, LensFile& lens) {
  const std::vector<double> size = in.numbers();
  const auto side = [](double v) { return v >= 1 && v <= 32768 && v == std::floor(v); };
  if (size.size() != 2 || !side(size[0]) || !side(size[1]))
    in.fail("has an imagersize that is no size", {}, "[ columns, rows ]");
  lens.columns = static_cast<int>(size[0]);
  lens.rows = static_cast<int>(size[1]);
}

}  // namespace

LensFile parse_lens_file(const std::string& text, const std::string& name) {
  Literals in(text, name);
  LensFile lens;
  std::set<std::string> seen;
  in.expect('{');
  while (!in.accept('}')) {
    const std::string key = in.string();
    in.expect(':');
    if (!seen.insert(key).second) in.fail("states a key twice", key, {});
    if (key == "lensmodel") {
      lens.model = in.string();
    } else if (key == "intrinsics") {
      lens.intrinsics = in.numbers();
    } else if (key == "imagersize") {
      read_size(in, lens);
    } else {
      in.skip_value();
    }
    if (in.peek() != '}') in.expect(',');
  }
  if (in.peek() != '\0') in.fail("goes on after its end", {}, {});
  for (const char* key : {"lensmodel", "intrinsics", "imagersize"}) {
    if (!seen.contains(key)) throw Error({name, std::string("lacks ") + key, {}, "an mrcal .cameramodel file"});
  }
  const auto count = intrinsics_of(lens.model);
  if (!count)
    throw Error({name + ": lensmodel", "is no lens model of mrcal 2.2", "'" + lens.model.substr(0, 80) + "'", {}});
  if (lens.intrinsics.size() != *count) {
    throw Error({name + ": intrinsics", "has the wrong number of values for " + lens.model,
                 std::to_string(lens.intrinsics.size()), std::to_string(*count)});
  }
  if (!(lens.intrinsics[0] > 0 && lens.intrinsics[1] > 0)) {
    throw Error({name + ": intrinsics", "has a focal length that is not positive", {}, {}});
  }
  return lens;
}

LensFile read_lens_file(const std::filesystem::path& path) {
  return parse_lens_file(read_text_file(path, kLargestFile_bytes), path.string());
}

std::string to_cameramodel(const LensFile& lens) {
  std::string intrinsics;
  for (const double v : lens.intrinsics) intrinsics += (intrinsics.empty() ? "" : ", ") + number_text(v);
  return "{\n'lensmodel': '" + lens.model + "',\n'intrinsics': [ " + intrinsics +
         " ],\n'extrinsics': [ 0, 0, 0, 0, 0, 0 ],\n'imagersize': [ " + std::to_string(lens.columns) + ", " +
         std::to_string(lens.rows) + " ]\n}\n";
}

}  // namespace scatmap
