#include "calib/spots_setting.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/output_file.h"
#include "scatmap/base/units.h"

namespace scatmap::calib {
namespace fs = std::filesystem;
namespace {

constexpr std::array<const char*, 9> kColumns{"file",  "kind",      "stage_deg", "arm_deg", "tilt_deg",
                                              "mount", "column_px", "row_px",    "sigma_px"};

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t\r") - first + 1));
}

std::vector<std::string> fields_of(std::string_view line) {
  std::vector<std::string> out;
  for (;;) {
    const auto comma = line.find(',');
    out.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return out;
    line.remove_prefix(comma + 1);
  }
}

std::map<std::string, std::size_t> read_header(const std::vector<std::string>& names, const std::string& where) {
  std::map<std::string, std::size_t> out;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::find(kColumns.begin(), kColumns.end(), names[i]) == kColumns.end()) {
      throw Error({where, "names a column that is not known", "'" + names[i] + "'",
                   "file, kind, stage_deg, arm_deg, tilt_deg, mount"});
    }
    if (!out.emplace(names[i], i).second) throw Error({where, "names a column twice", names[i], {}});
  }
  if (!out.contains("file")) throw Error({where, "lacks the column file", {}, {}});
  return out;
}

std::optional<double> angle_deg(const std::string& text, const std::string& where) {
  if (text.empty()) return std::nullopt;
  const std::string digits = text.front() == '+' ? text.substr(1) : text;
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc() && end == digits.data() + digits.size() && value >= -360 && value <= 360) return value;
  throw Error({where, "is no angle", "'" + text + "'", "degrees from -360 to 360"});
}

std::optional<std::string> stated(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional<std::string>(text);
}

fs::path resolved(const fs::path& path) { return fs::weakly_canonical(fs::absolute(path)); }

template <class T>
std::optional<T> either(const std::optional<T>& first, const std::optional<T>& second) {
  return first ? first : second;
}

double required_deg(const std::optional<double>& value, const char* key, const char* card, const fs::path& frame) {
  if (value) return *value;
  throw Error({frame.string(),
               std::string(key) + " is not stated",
               {},
               std::string("the FITS card ") + card + ", a line of --angles, or the command line"});
}

}  // namespace

TargetKind parse_kind(const std::string& text, const std::string& where) {
  if (text == "specular") return TargetKind::kSpecular;
  if (text == "direct") return TargetKind::kDirect;
  throw Error({where, "is not known", "'" + text + "'", "specular or direct"});
}

SettingTable SettingTable::read(const fs::path& path) {
  SettingTable out;
  out.name_ = path.string();
  const std::string text = read_text_file(path);
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  std::map<std::string, std::size_t> columns;
  for (int number = 1; !rest.empty(); ++number) {
    const auto end = rest.find('\n');
    const std::string line = trimmed(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (line.empty() || line.front() == '#') continue;
    const std::string where = out.name_ + ":" + std::to_string(number);
    const std::vector<std::string> fields = fields_of(line);
    if (columns.empty()) {
      columns = read_header(fields, where);
      continue;
    }
    if (fields.size() != columns.size()) {
      throw Error({where, "has the wrong number of fields", std::to_string(fields.size()),
                   std::to_string(columns.size()) + " as in the header"});
    }
    const auto field = [&](const char* name) {
      return columns.contains(name) ? fields[columns.at(name)] : std::string();
    };
    if (field("file").empty()) throw Error({where + ": file", "is empty", {}, {}});
    SpotSetting s{{},
                  angle_deg(field("stage_deg"), where + ": stage_deg"),
                  angle_deg(field("arm_deg"), where + ": arm_deg"),
                  angle_deg(field("tilt_deg"), where + ": tilt_deg"),
                  stated(field("mount"))};
    if (!field("kind").empty()) s.kind = parse_kind(field("kind"), where + ": kind");
    out.lines_.push_back({resolved(path.parent_path() / field("file")), s});
  }
  if (out.lines_.empty()) throw Error({out.name_, "lists no frame", {}, {}});
  return out;
}

const SettingTable::Line* SettingTable::line_of(const fs::path& frame) const {
  const fs::path wanted = resolved(frame);
  for (const bool whole : {true, false}) {
    const Line* found = nullptr;
    for (const Line& line : lines_) {
      if (whole ? line.file != wanted : line.file.filename() != wanted.filename()) continue;
      if (found != nullptr) throw Error({name_, "has more than one line for a frame", frame.string(), {}});
      found = &line;
    }
    if (found != nullptr) return found;
  }
  return nullptr;
}

std::optional<SpotSetting> SettingTable::find(const fs::path& frame) const {
  const Line* line = line_of(frame);
  return line == nullptr ? std::nullopt : std::optional(line->setting);
}

void SettingTable::require_one_frame_each(const std::vector<std::string>& frames) const {
  std::map<const Line*, std::string> frame_of;
  for (const std::string& frame : frames) {
    const Line* line = line_of(frame);
    if (line == nullptr) continue;
    const auto [other, is_new] = frame_of.emplace(line, frame);
    if (!is_new)
      throw Error({name_,
                   "has one line, by its file name, for " + other->second + " and " + frame,
                   {},
                   "the path of each, beside the table"});
  }
}

SpotSetting combined(const SpotSetting& first, const SpotSetting& second) {
  return {either(first.kind, second.kind), either(first.stage_deg, second.stage_deg),
          either(first.arm_deg, second.arm_deg), either(first.tilt_deg, second.tilt_deg),
          either(first.mount, second.mount)};
}

SpotSetting header_setting(const Frame& frame) {
  SpotSetting s{{}, frame.header.stage_deg, frame.header.arm_deg, frame.header.tilt_deg, {}};
  std::string target = frame.header.target.value_or("");
  std::transform(target.begin(), target.end(), target.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (target == "specular" || target == "direct") s.kind = parse_kind(target, frame.file.string() + ": TARGET");
  return s;
}

std::optional<std::string> doubt_of_kind(const SpotSetting& setting) {
  if (setting.kind || !setting.stage_deg || !setting.arm_deg) return std::nullopt;
  const auto apart_deg = [](double a, double b) { return std::abs(std::remainder(a - b, 360)); };
  const double specular_deg = 2 * *setting.stage_deg;
  if (apart_deg(*setting.arm_deg, specular_deg) <= kMirrorReach_deg) return std::nullopt;
  if (apart_deg(*setting.arm_deg, 180) > kMirrorReach_deg) return std::nullopt;
  return "nothing says its kind, and a mirror at stage " + number_text(*setting.stage_deg) + " sends the beam to arm " +
         number_text(specular_deg) + ", not " + number_text(*setting.arm_deg) +
         "; written as specular; if it is the direct beam, say so: the FITS card TARGET = 'direct', the column kind of "
         "--angles, or --kind direct";
}

Target target_of(const SpotSetting& setting, const fs::path& frame) {
  Target t;
  t.kind = setting.kind.value_or(TargetKind::kSpecular);
  t.stage_rad = required_deg(setting.stage_deg, "the stage angle", "STAGEDEG", frame) * kRadPerDeg;
  t.arm_rad = required_deg(setting.arm_deg, "the arm angle", "ARMDEG", frame) * kRadPerDeg;
  constexpr double kMostTilt_deg = 89;
  const double tilt_deg = setting.tilt_deg.value_or(0);
  if (!(std::abs(tilt_deg) <= kMostTilt_deg))
    throw Error({frame.string() + ": TILTDEG", "is no mirror tilt", number_text(tilt_deg), "-89 to 89 degrees"});
  t.tilt_rad = tilt_deg * kRadPerDeg;
  if (t.kind == TargetKind::kDirect && (t.tilt_rad != 0 || !setting.mount.value_or("").empty())) {
    throw Error({frame.string(), "has a mirror tilt or mount, but is a direct beam, which meets no mirror", {}, {}});
  }
  return t;
}

}  // namespace scatmap::calib
