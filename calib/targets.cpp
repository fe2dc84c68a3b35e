#include "calib/targets.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>
#include <tuple>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/output_file.h"
#include "scatmap/base/units.h"

namespace scatmap::calib {
namespace {

constexpr std::array<const char*, 9> kColumns{"kind",   "stage_deg", "arm_deg", "tilt_deg", "column_px",
                                              "row_px", "sigma_px",  "mount",   "file"};
constexpr std::size_t kRequired = 7;
constexpr double kFarthestPx = 1e6;

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> out;
  for (;;) {
    const auto comma = line.find(',');
    out.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return out;
    line.remove_prefix(comma + 1);
  }
}

// One data line, its fields found by column name.
class Row {
 public:
  Row(std::string where, const std::map<std::string, std::size_t>& columns, std::vector<std::string_view> fields)
      : where_(std::move(where)), columns_(columns), fields_(std::move(fields)) {
    if (fields_.size() == columns_.size()) return;
    throw Error({where_, "has the wrong number of fields", std::to_string(fields_.size()),
                 std::to_string(columns_.size()) + " as in the header"});
  }

  std::string text(const std::string& column) const {
    const auto found = columns_.find(column);
    return found == columns_.end() ? std::string() : std::string(fields_[found->second]);
  }

  double number(const std::string& column, double minimum, double maximum) const {
    std::string field = text(column);
    const std::string digits = field.rfind('+', 0) == 0 ? field.substr(1) : field;
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size()) {
      throw Error({where_ + ": " + column, "is not a number", "'" + field + "'", {}});
    }
    if (value >= minimum && value <= maximum) return value;
    throw Error({where_ + ": " + column, "is out of range", field,
                 "from " + number_text(minimum) + " to " + number_text(maximum)});
  }

  const std::string& where() const { return where_; }

 private:
  std::string where_;
  const std::map<std::string, std::size_t>& columns_;
  std::vector<std::string_view> fields_;
};

std::map<std::string, std::size_t> read_header(const std::string& where, std::string_view line) {
  std::map<std::string, std::size_t> columns;
  const auto names = fields_of(line);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string name(names[i]);
    if (std::find(kColumns.begin(), kColumns.end(), name) == kColumns.end()) {
      throw Error({where, "names a column that targets do not have", "'" + name + "'",
                   "kind, stage_deg, arm_deg, tilt_deg, column_px, row_px, sigma_px, mount, file"});
    }
    if (!columns.emplace(name, i).second) throw Error({where, "names a column twice", name, {}});
  }
  for (std::size_t i = 0; i < kRequired; ++i) {
    if (columns.count(kColumns[i]) == 0) throw Error({where, "lacks the column " + std::string(kColumns[i]), {}, {}});
  }
  return columns;
}

TargetKind read_kind(const Row& row) {
  const std::string kind = row.text("kind");
  if (kind == "specular") return TargetKind::kSpecular;
  if (kind == "direct") return TargetKind::kDirect;
  throw Error({row.where() + ": kind", "is not known", "'" + kind + "'", "specular or direct"});
}

std::size_t mount_index(std::vector<std::string>& mounts, const std::string& name) {
  const auto found = std::find(mounts.begin(), mounts.end(), name);
  if (found != mounts.end()) return static_cast<std::size_t>(found - mounts.begin());
  mounts.push_back(name);
  return mounts.size() - 1;
}

Target read_target(const Row& row, std::vector<std::string>& mounts) {
  constexpr double kSmallestSigmaPx = 1e-6;
  Target t;
  t.kind = read_kind(row);
  t.stage_rad = row.number("stage_deg", -360, 360) * kRadPerDeg;
  t.arm_rad = row.number("arm_deg", -360, 360) * kRadPerDeg;
  t.tilt_rad = row.number("tilt_deg", -89, 89) * kRadPerDeg;
  t.column_px = row.number("column_px", -kFarthestPx, kFarthestPx);
  t.row_px = row.number("row_px", -kFarthestPx, kFarthestPx);
  t.sigma_px = row.number("sigma_px", kSmallestSigmaPx, kFarthestPx);
  t.file = row.text("file");
  const std::string mount = row.text("mount");
  if (t.kind == TargetKind::kSpecular) {
    if (!is_mount_name(mount)) {
      throw Error({row.where() + ": mount", "is not a plain name", "'" + mount + "'",
                   "letters, digits, '-', '_', '.' and spaces"});
    }
    t.mount = mount_index(mounts, mount);
    return t;
  }
  if (!mount.empty())
    throw Error({row.where() + ": mount", "is given for a direct beam, which meets no mirror", mount, {}});
  if (t.tilt_rad != 0) {
    throw Error(
        {row.where() + ": tilt_deg", "is given for a direct beam, which meets no mirror", row.text("tilt_deg"), "0"});
  }
  return t;
}

// What makes a target the same as another, however its numbers are written: to 1e-6 px and 1e-9 rad.
using Spot = std::tuple<TargetKind, std::size_t, std::array<long long, 5>, std::string>;

Spot spot_of(const Target& t) {
  constexpr double kPerPx = 1e6, kPerRad = 1e9;
  const auto whole = [](double value) { return std::llround(value); };
  return {t.kind,
          t.mount,
          {whole(t.stage_rad * kPerRad), whole(t.arm_rad * kPerRad), whole(t.tilt_rad * kPerRad),
           whole(t.column_px * kPerPx), whole(t.row_px * kPerPx)},
          t.file};
}

}  // namespace

bool is_mount_name(const std::string& name) {
  return std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.' || c == ' ';
  });
}

TargetList parse_targets(const std::string& text, const std::string& name) {
  TargetList list{name, {}, {}};
  std::map<std::string, std::size_t> columns;
  std::map<Spot, int> seen;  // the same spot twice is no second measurement
  std::string_view rest = text;
  if (rest.substr(0, 3) == "\xEF\xBB\xBF") rest.remove_prefix(3);
  for (int number = 1; !rest.empty(); ++number) {
    const auto end = rest.find('\n');
    const std::string_view line = trimmed(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (line.empty() || line.front() == '#') continue;
    const std::string where = name + ":" + std::to_string(number);
    if (line.find('"') != std::string_view::npos)
      throw Error({where, "contains a quotation mark; fields are plain", {}, {}});
    if (columns.empty()) {
      columns = read_header(where, line);
      continue;
    }
    list.targets.push_back(read_target(Row(where, columns, fields_of(line)), list.mounts));
    list.targets.back().line = number;
    const auto [at, is_new] = seen.emplace(spot_of(list.targets.back()), number);
    if (!is_new) throw Error({where, "repeats line " + std::to_string(at->second), {}, "each target once"});
  }
  if (columns.empty()) throw Error({name, "is empty", {}, "a header line and one target a line"});
  if (list.targets.empty()) throw Error({name, "lists no target", {}, {}});
  return list;
}

TargetList read_targets(const std::filesystem::path& path) {
  return parse_targets(read_text_file(path), path.string());
}

std::string to_csv(const TargetList& list) {
  std::string text = "kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px,mount,file\n";
  for (const Target& t : list.targets) {
    const bool direct = t.kind == TargetKind::kDirect;
    text += std::string(direct ? "direct," : "specular,") + number_text_in_unit(t.stage_rad, kRadPerDeg) + "," +
            number_text_in_unit(t.arm_rad, kRadPerDeg) + "," + number_text_in_unit(t.tilt_rad, kRadPerDeg) + "," +
            number_text(t.column_px) + "," + number_text(t.row_px) + "," + number_text(t.sigma_px) + "," +
            (direct ? "" : list.mounts[t.mount]) + "," + t.file + "\n";
  }
  return text;
}

std::string label(const TargetList& list, const Target& target) {
  const std::string place = list.name + ":" + std::to_string(target.line);
  return target.file.empty() ? place : place + " (" + target.file + ")";
}

}  // namespace scatmap::calib
