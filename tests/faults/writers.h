#pragma once
#include <chrono>
#include <set>

#include "cli/lab.h"
#include "faults/process.h"
#include "frame/fits_sums.h"

namespace scatmap::test {

/// A run of the tool that writes one output over an old one.
struct Writer {
  std::string name;
  std::vector<std::string> command;
  std::string output;  ///< file or folder in the laboratory
  std::string marker;  ///< of a folder; empty for a file
};

/// One per kind of output. `big.toml` makes writing, not computing, the longest part of the run.
inline std::vector<Writer> writers() {
  const std::vector<std::string> pose{"--stage-deg", "20", "--arm-deg", "40", "--force"};
  const auto with_pose = [&](std::vector<std::string> command) {
    command.insert(command.end(), pose.begin(), pose.end());
    return command;
  };
  return {
      {"FITS", with_pose({"angles", "big.toml", "-o", "out.fits"}), "out.fits", ""},
      {"map", {"brdf", "measurement.toml", "-o", "map.fits", "--force"}, "map.fits", ""},
      {"EXR", with_pose({"angles", "big.toml", "-o", "out.exr"}), "out.exr", ""},
      {"CSV",
       {"spots", "frames/signature_001.fits", "--instrument", "instrument.toml", "--kind", "direct", "--stage-deg", "0",
        "--arm-deg", "180", "--tilt-deg", "0", "-o", "spots.csv", "--force"},
       "spots.csv",
       ""},
      {"TOML",
       {"calibrate", "targets.csv", "--instrument", "instrument.toml", "-o", "calibrated.toml", "--force"},
       "calibrated.toml",
       ""},
      {"pictures",
       {"compare", "maps/measured.fits", "maps/modelled.fits", "-o", "pictures", "--force"},
       "pictures",
       "comparison.json"},
      {"simulate", {"simulate", "scene.toml", "-o", "simulated", "--force"}, "simulated", "truth/scene.toml"},
      {"chart",
       {"chart", "angles", "--seconds", "0.01", "--scene", "measurement.toml", "-o", "chart", "--force"},
       "chart",
       "charts.csv"},
  };
}

/// A laboratory in which every writer works.
inline void complete(Lab& lab) {
  std::string big = lab.read("instrument.toml");
  for (const char* key : {"columns = 64", "rows = 64"}) {
    const std::size_t at = big.find(key);
    if (at == std::string::npos) throw std::runtime_error("instrument.toml has changed");
    big.replace(at, std::string(key).size(), std::string(key).substr(0, std::string(key).find('=')) + "= 512");
  }
  lab.write("big.toml", big);
  std::string targets = "kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px\n";
  for (const char* line :
       {"direct,0,180,0,31.5,31.5,0.02", "direct,0,179.5,0,18.15,31.5,0.02", "specular,10,20,0,31.5,31.5,0.02",
        "specular,20,40,0,31.5,31.5,0.02", "specular,30,60,0,31.5,31.5,0.02", "specular,30,60.5,0,44.9,31.5,0.02"}) {
    targets += std::string(line) + "\n";
  }
  lab.write("targets.csv", targets);
}

inline void put_old(const Lab& lab, const Writer& w) {
  fs::remove_all(lab.path(w.output));
  if (w.marker.empty()) {
    lab.write(w.output, "old\n");
  } else {
    fs::create_directories(lab.path(w.output + "/" + w.marker).parent_path());
    lab.write(w.output + "/" + w.marker, "old\n");
  }
}

/// The bytes without what may differ from run to run: CFITSIO writes the time into the comments of checksum cards, and
/// the checksum covers them. Pictures and charts: only whether they are whole.
inline std::string comparable(const std::string& name, std::string bytes, const std::string& writer) {
  if (name.ends_with(".png")) return bytes.ends_with(std::string("IEND\xae\x42\x60\x82")) ? "whole" : "cut";
  if (name.ends_with(".svg")) return bytes.ends_with("</svg>\n\n") || bytes.ends_with("</svg>\n") ? "whole" : "cut";
  if (writer == "chart") {
    return std::to_string(std::count(bytes.begin(), bytes.end(), '\n')) + (bytes.ends_with("\n") ? "" : "cut");
  }
  return name.ends_with(".fits") ? without_fits_sums(std::move(bytes)) : bytes;  // CHECKSUM cards hold the time
}

/// File name to comparable content; for a file one entry.
using Content = std::map<std::string, std::string>;

inline Content content(const Lab& lab, const Writer& w) {
  Content out;
  if (w.marker.empty()) {
    if (fs::exists(lab.path(w.output))) out[w.output] = comparable(w.output, lab.read(w.output), w.name);
    return out;
  }
  if (!fs::exists(lab.path(w.output))) return out;
  for (const auto& entry : fs::recursive_directory_iterator(lab.path(w.output))) {
    const std::string name = entry.path().lexically_relative(lab.folder()).string();
    if (entry.is_regular_file()) out[name] = comparable(name, lab.read(name), w.name);
  }
  return out;
}

/// Everything hidden that a run may have left anywhere in the laboratory, TMPDIR included.
inline std::vector<std::string> leftovers(const Lab& lab) {
  std::vector<std::string> out;
  for (const auto& entry : fs::recursive_directory_iterator(lab.folder())) {
    if (entry.path().filename().string().find("scatmap-") != std::string::npos) out.push_back(entry.path().string());
  }
  return out;
}

using Clock = std::chrono::steady_clock;
inline double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace scatmap::test
