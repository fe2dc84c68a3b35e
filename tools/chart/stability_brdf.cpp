#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/units.h"
#include "scatmap/brdf/from_frames.h"
#include "tools/chart/scene.h"
#include "tools/chart/stability.h"

namespace scatmap::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kColumns = 40, kRows = 24, kFrames = 3, kLargeSide = 16384;
constexpr int kColumnStride = 13;  // of wide frames, every so many columns are looked at
constexpr double kBias_dn = 300, kAperture_px = 9;
constexpr int kHot_dn = 10000;

// A measurement of frames without noise, whose map follows by hand.
struct Bench {
  double gain_e_per_dn = 1.5;
  double exposure_s = 0.05, signature_s = 2;
  double od = 3, signature_od = 7;
  double pitch_um = 300, row_offset_mm = 0;
  Grid<int> sample, dark, signature;
  int rows() const { return sample.rows(); }
  int columns() const { return sample.columns(); }
  int stride() const { return columns() > kColumns ? kColumnStride : 1; }
};

Bench plain(int columns = kColumns) {
  Bench b;
  b.sample = Grid<int>(kRows, columns, 2000);
  b.dark = b.signature = Grid<int>(kRows, columns, 300);
  const int middle_row = kRows / 2, middle_column = columns / 2;
  for (int dr = -2; dr <= 2; ++dr) {
    for (int dc = -2; dc <= 2; ++dc)
      b.signature(middle_row + dr, middle_column + dc) += 30000 / (1 + dr * dr * dr * dr + dc * dc * dc * dc);
  }
  return b;
}

struct Regime {
  const char* name;
  Bench bench;
};

template <class Change>
Bench changed(Change change) {
  Bench b = plain();
  change(b);
  return b;
}

void fill(Grid<int>& frame, int value) {
  for (int& v : frame) v = value;
}

// A strip of a frame of 16384 x 16384 pixels, whose planes would take ten gigabytes.
Bench strip_of_large(int first_row) {
  Bench b = plain(kLargeSide);
  b.pitch_um = 5.5;
  b.row_offset_mm = (first_row + 0.5 * (kRows - 1) - 0.5 * (kLargeSide - 1)) * b.pitch_um * 1e-3;
  return b;
}

std::vector<Regime> regimes() {
  return {
      {"plain", plain()},
      {"16384 x 16384 frame, its first rows", strip_of_large(0)},
      {"16384 x 16384 frame, its last rows", strip_of_large(kLargeSide - kRows)},
      {"counts all 0", changed([](Bench& b) { fill(b.sample, 0); })},
      {"counts all 1", changed([](Bench& b) { fill(b.sample, 1); })},
      {"one electron above the dark", changed([](Bench& b) { fill(b.sample, 301); })},
      {"all saturated", changed([](Bench& b) { fill(b.sample, 65535); })},
      {"dark above the signal", changed([](Bench& b) { fill(b.sample, 250); })},
      {"dark as high as saturation", changed([](Bench& b) { fill(b.dark, 65535); })},
      {"one hot pixel of 65535", changed([](Bench& b) { b.sample(5, 7) = b.dark(5, 7) = 65535; })},
      {"one saturated pixel", changed([](Bench& b) { b.sample(5, 7) = 65535; })},
      {"gain 0", changed([](Bench& b) { b.gain_e_per_dn = 0; })},
      {"gain 1e-6", changed([](Bench& b) { b.gain_e_per_dn = 1e-6; })},
      {"gain 1e6", changed([](Bench& b) { b.gain_e_per_dn = 1e6; })},
      {"exposure 1e-9 s", changed([](Bench& b) { b.exposure_s = 1e-9; })},
      {"exposure 1e6 s", changed([](Bench& b) { b.exposure_s = 1e6; })},
      {"OD 0 against 0", changed([](Bench& b) { b.od = b.signature_od = 0; })},
      {"OD 12 against 0", changed([](Bench& b) {
         b.od = 12;
         b.signature_od = 0;
       })},
      {"OD 0 against 12", changed([](Bench& b) {
         b.od = 0;
         b.signature_od = 12;
       })},
      {"signature of one pixel", changed([](Bench& b) {
         fill(b.signature, 300);
         b.signature(kRows / 2, kColumns / 2) = 30300;
       })},
      {"signature of none", changed([](Bench& b) { fill(b.signature, 300); })},
      {"signature saturated", changed([](Bench& b) { b.signature(kRows / 2, kColumns / 2) = 65535; })},
  };
}

class PrivateFolder {
 public:
  PrivateFolder() {
    std::string name = (fs::temp_directory_path() / "scatmap-stability-XXXXXX").string();
    if (!mkdtemp(name.data())) throw Error({name, "cannot make a temporary folder", {}, {}});
    path_ = name;
  }
  ~PrivateFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string copy_name(const std::string& name, int copy) { return name + "_" + std::to_string(copy) + ".pgm"; }

// kFrames frames that are alike.
void write_pgms(const Grid<int>& frame, const fs::path& folder, const std::string& name) {
  for (int copy = 0; copy < kFrames; ++copy) {
    std::ofstream out(folder / copy_name(name, copy), std::ios::binary);
    out << "P5\n# frame " << copy_name(name, copy) << "\n" << frame.columns() << " " << frame.rows() << "\n65535\n";
    for (const int v : frame) out.put(static_cast<char>(v >> 8)).put(static_cast<char>(v & 255));
  }
}

synth::Bench geometry(const Bench& bench) {
  synth::Bench b;
  b.columns = bench.columns();
  b.rows = bench.rows();
  b.pitch_um = {bench.pitch_um, bench.pitch_um};
  b.distance_mm = 325;
  b.offset_mm = {0, bench.row_offset_mm};
  return b;
}

constexpr double kStage_deg = 20, kArm_deg = 41;

std::string exposure_text(const char* table, const char* frame, double exposure_s, double od, const std::string& more) {
  const auto copies = [](const std::string& name) {
    std::string out;
    for (int i = 0; i < kFrames; ++i) out += (i == 0 ? "\"" : ", \"") + copy_name(name, i) + "\"";
    return out;
  };
  return std::string(table) + "\nframes = [" + copies(frame) + "]\ndarks = [" + copies("dark") +
         "]\nexposure_s = " + number_text(exposure_s) + "\nfilters = [\"" + (od == 0 ? "none" : frame) + "\"]\n" + more;
}

fs::path written(const Bench& b, const fs::path& folder) {
  write_pgms(b.sample, folder, "sample");
  write_pgms(b.dark, folder, "dark");
  write_pgms(b.signature, folder, "signature");
  std::ofstream(folder / "instrument.toml")
      << "[detector]\ncolumns = " << b.columns() << "\nrows = " << b.rows() << "\npitch_um = ["
      << number_text(b.pitch_um) << ", " << number_text(b.pitch_um) << "]\ndistance_mm = 325\noffset_mm = [0, "
      << number_text(b.row_offset_mm) << "]\n"
      << "[sensor]\ngain_e_per_dn = " << number_text(b.gain_e_per_dn)
      << "\nread_noise_e = 8\nsaturation_dn = 60000\nbias_dn = " << number_text(kBias_dn) << "\n";
  const auto filter = [](const char* name, double od) {
    return std::string("[filters.\"") + name + "\"]\nod = " + number_text(od) + "\ntolerance_percent = 5\n";
  };
  std::ofstream(folder / "measurement.toml")
      << "instrument = \"instrument.toml\"\nwavelength_nm = 632.8\nstage_deg = 20\narm_deg = 41\n"
      << filter("none", 0) << filter("sample", b.od) << filter("signature", b.signature_od)
      << exposure_text("[signature]", "signature", b.signature_s, b.signature_od,
                       "aperture_radius_px = " + number_text(kAperture_px) + "\n")
      << exposure_text("[[exposure]]", "sample", b.exposure_s, b.od, "");
  return folder / "measurement.toml";
}

double beam_dn(const Bench& b) {
  double sum = 0;
  for (std::size_t i = 0; i < b.signature.size(); ++i) {
    if (b.dark[i] < kHot_dn) sum += b.signature[i] - b.dark[i];
  }
  return sum;
}

// The measurement equation by hand.
class Expected {
 public:
  explicit Expected(const Bench& b)
      : b_(b),
        geometry_(geometry(b), kStage_deg, kArm_deg),
        beam_rate_(beam_dn(b) / (b.signature_s * std::pow(10.0L, -static_cast<long double>(b.signature_od)))) {}

  /// Nothing where the pixel is no good.
  std::optional<long double> at(int row, int column) const {
    const auto pixel = geometry_.pixel(column, row);
    if (spoilt(row, column) || b_.dark(row, column) > kHot_dn || !pixel) return std::nullopt;
    const long double rate = (b_.sample(row, column) - b_.dark(row, column)) /
                             (b_.exposure_s * std::pow(10.0L, -static_cast<long double>(b_.od)));
    return rate / beam_rate_ / (pixel->solid_angle_sr * std::cos(pixel->theta_s_rad));
  }

 private:
  // By its own saturation or a neighbour's. A pixel that is hot in the darks is full by itself and spills nothing.
  bool spoilt(int row, int column) const {
    for (int r = std::max(0, row - 1); r <= std::min(b_.rows() - 1, row + 1); ++r) {
      for (int c = std::max(0, column - 1); c <= std::min(b_.columns() - 1, column + 1); ++c) {
        if (b_.sample(r, c) >= 60000 && b_.dark(r, c) < kHot_dn) return true;
      }
    }
    return false;
  }

  const Bench& b_;
  synth::TruthGeometry geometry_;
  long double beam_rate_;
};

struct Method {
  const char* name;
  double bound;
  std::function<BrdfMap(const Measurement&)> map;
};

std::vector<Method> methods() {
  constexpr double kBound = 1e-6;  // variances pass through float32
  const auto by = [](BrdfMethod method) {
    return [method](const Measurement& m) { return brdf_from_frames(m, {}, FilterValues::kByOverlap, method).map; };
  };
  return {{"fused", kBound, by(BrdfMethod::kFused)}, {"exact", kBound, by(BrdfMethod::kExact)}};
}

// Worst relative error; says what is wrong otherwise.
std::pair<double, std::string> judged(const BrdfMap& map, const Bench& b) {
  const Expected expected(b);
  double worst = 0;
  for (int row = 0; row < b.rows(); ++row) {
    for (int column = 0; column < b.columns(); column += b.stride()) {
      const auto truth = expected.at(row, column);
      const bool good = map.mask(row, column) == 0;
      if (good != truth.has_value()) return {worst, good ? "number where there is none" : "no number"};
      if (!good) {
        if (!std::isnan(map.brdf_per_sr(row, column))) return {worst, "masked, but a number"};
        continue;
      }
      if (!(map.u_random_per_sr(row, column) > 0)) return {worst, "no random uncertainty"};
      const double f = map.brdf_per_sr(row, column), t = static_cast<double>(*truth);
      const double error = f == t ? 0 : std::abs(f - t) / std::abs(t);
      if (!(error <= worst)) worst = error;
    }
  }
  return {worst, ""};
}

// Largest relative change of the answer over that of the truth when the sample's exposure and density move by
// `step(value)`: down, for a density may be the largest there is.
template <class Step>
double amplification(const Bench& b, const Method& method, const BrdfMap& map, Step step) {
  Bench moved = b;
  for (double* v : {&moved.exposure_s, &moved.od}) *v = step(*v);
  const PrivateFolder folder;
  const BrdfMap after = method.map(read_measurement(written(moved, folder.path())));
  const Expected before(b), then(moved);
  double answer = 0, truth = 0;
  for (int row = 0; row < b.rows(); ++row) {
    for (int column = 0; column < b.columns(); column += b.stride()) {
      const auto from = before.at(row, column), to = then.at(row, column);
      if (!from || !to || *from == 0 || map.mask(row, column) != 0 || after.mask(row, column) != 0) continue;
      const auto scale = static_cast<double>(std::abs(*from));
      truth = std::max(truth, static_cast<double>(std::abs(*to - *from)) / scale);
      answer = std::max(answer, std::abs(after.brdf_per_sr(row, column) - map.brdf_per_sr(row, column)) / scale);
    }
  }
  return truth > 0 ? answer / truth : std::numeric_limits<double>::quiet_NaN();
}

bool some_pixel_expected(const Bench& b) {
  for (const int v : b.signature) {
    if (v >= 60000) return false;
  }
  constexpr double kSeen_e = 400;  // fewer electrons in the beam's five by five pixels drown in their own noise
  if (!(beam_dn(b) * b.gain_e_per_dn > kSeen_e)) return false;
  const Expected expected(b);
  for (int i = 0; i < b.rows() * b.columns(); i += b.stride()) {
    if (expected.at(i / b.columns(), i % b.columns())) return true;
  }
  return false;
}

StabilityCell cell_of(const Regime& regime, const Method& method) {
  StabilityCell cell;
  cell.job = "brdf";
  cell.regime = regime.name;
  cell.method = method.name;
  cell.bound = method.bound;
  const PrivateFolder folder;
  try {
    const BrdfMap map = method.map(read_measurement(written(regime.bench, folder.path())));
    std::tie(cell.worst_error, cell.reason) = judged(map, regime.bench);
    if (cell.reason.empty() && cell.worst_error <= cell.bound) cell.verdict = Verdict::kHolds;
    cell.amplification_ulp = amplification(regime.bench, method, map, [](double v) { return std::nextafter(v, 0.0); });
    cell.amplification_sigma = amplification(regime.bench, method, map, [](double v) { return v * (1 - 1e-3); });
  } catch (const Error& e) {
    cell.reason = e.what();
    const std::string prefix = folder.path().string() + "/";
    if (const auto at = cell.reason.find(prefix); at != std::string::npos) cell.reason.erase(at, prefix.size());
    cell.verdict = some_pixel_expected(regime.bench) ? Verdict::kFails : Verdict::kRefuses;
  }
  return cell;
}

}  // namespace

std::vector<StabilityCell> stability_brdf() {
  std::vector<StabilityCell> out;
  for (const Regime& regime : regimes()) {
    for (const Method& method : methods()) out.push_back(cell_of(regime, method));
  }
  return out;
}

}  // namespace scatmap::tools
