#pragma once
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cli/run_tool.h"

namespace scatmap::test {
namespace fs = std::filesystem;

/// Numbers are binary fractions, so that the files made from them hold the same digits.
inline constexpr const char* kScene = R"(kind = "brdf"
seed = 20
wavelength_nm = 512.0
polarization = "s"
stage_deg = 20.0
arm_deg = 40.0

[detector]
columns = 64
rows = 64
pitch_um = [212.5, 212.5]
distance_mm = 325.0

[beam]
signature_diameter_mm = 1.0

[sensor]
gain_e_per_dn = 1.5
read_noise_e = 8.0
bias_dn = 300.0
saturation_dn = 65535.0
full_well_e = 120000.0
dark_e_per_s = 2.0
hot_pixels = 4
hot_e_per_s = 6000.0

[laser]
electrons_per_s = 8e+11
drift_tolerance_percent = 0.5

[filters.nd40]
od = 4.0
tolerance_percent = 5.0

[filters.nd30]
od = 3.0
tolerance_od = 0.125

[filters.nd10]
od = 1.0
u_od = 0.03125

[signature]
exposure_s = 0.03125
frames = 2
darks = 3
filters = ["nd40", "nd10"]
arm_deg = 180.0

[[exposure]]
exposure_s = 0.25
frames = 2
darks = 3
filters = ["nd30"]

[[term]]
kind = "microfacet"
rho = 0.5
m = 0.0078125
n = [1.5, 0.25]

[[term]]
kind = "stripes"
rho = 300.0
a_um = 800.0
b_um = 10.0
c_um = 40.0
form = "grating"
)";

/// A small laboratory: what `simulate` writes, its scene.toml, and maps/angles.fits, maps/measured.fits,
/// maps/modelled.fits made from it. Paths are relative to its folder, in which the tool runs.
class Lab {
 public:
  explicit Lab(fs::path folder) : folder_(std::move(folder)) {}
  const fs::path& folder() const { return folder_; }
  fs::path path(const std::string& file) const { return folder_ / file; }

  std::string read(const std::string& file) const {
    std::ifstream in(path(file), std::ios::binary);
    std::string bytes(fs::file_size(path(file)), '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!in) throw std::runtime_error("cannot read " + file);
    return bytes;
  }
  void write(const std::string& file, const std::string& bytes) const {
    std::ofstream out(path(file), std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!out.flush()) throw std::runtime_error("cannot write " + file);
  }
  /// The first `from` becomes `to`; edited_line() is then the line in which `to` ends.
  void replace(const std::string& file, const std::string& from, const std::string& to) {
    std::string text = read(file);
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw std::runtime_error(file + " holds no '" + from + "'");
    text.replace(at, from.size(), to);
    edited_line_ = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at + to.size()), '\n');
    write(file, text);
  }
  long edited_line() const { return edited_line_; }

  /// Everything under the folder: bytes of readable files, "(folder)" for folders.
  std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> out;
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      const std::string name = entry.path().lexically_relative(folder_).string();
      if (entry.is_symlink()) {
        out[name] = "-> " + fs::read_symlink(entry.path()).string();
      } else if (entry.is_directory()) {
        out[name] = "(folder)";
      } else {
        out[name] = access(entry.path().c_str(), R_OK) == 0 ? read(name) : "(unreadable)";
      }
    }
    return out;
  }

 private:
  fs::path folder_;
  long edited_line_ = 0;
};

/// Made once per program; every case works on a copy of its own.
class LabMaker {
 public:
  LabMaker() : root_(fs::path(testing::TempDir()) / ("scatmap-cli-" + std::to_string(getpid()))) {
    fs::create_directories(root_);
    Lab(root_).write("scene.toml", kScene);
    run(root_, {"simulate", "scene.toml", "-o", "lab"});
    const fs::path lab = root_ / "lab";
    fs::rename(root_ / "scene.toml", lab / "scene.toml");
    fs::remove_all(lab / "truth");
    fs::create_directory(lab / "maps");
    fs::create_directory(lab / "tmp");
    run(lab, {"angles", "instrument.toml", "--stage-deg", "20", "--arm-deg", "40", "-o", "maps/angles.fits"});
    run(lab, {"brdf", "measurement.toml", "-o", "maps/measured.fits"});
    run(lab, {"model", "model.toml", "--like", "maps/measured.fits", "-o", "maps/modelled.fits"});
  }
  LabMaker(const LabMaker&) = delete;
  LabMaker& operator=(const LabMaker&) = delete;
  ~LabMaker() {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }
  Lab fresh_copy() const {
    const fs::path copy = root_ / "copy";
    fs::remove_all(copy);
    fs::copy(root_ / "lab", copy, fs::copy_options::recursive);
    return Lab(copy);
  }

 private:
  static void run(const fs::path& folder, const std::vector<std::string>& arguments) {
    const ToolRun done = run_tool(arguments, folder);
    if (done.status != 0) throw std::runtime_error("scatmap " + arguments.front() + " failed: " + done.err);
  }
  fs::path root_;
};

}  // namespace scatmap::test
