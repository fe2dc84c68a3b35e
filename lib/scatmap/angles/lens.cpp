#include "scatmap/angles/lens.h"

#include <dlfcn.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "scatmap/angles/lens_file.h"
#include "scatmap/angles/lens_module.h"
#include "scatmap/angles/opencv_lens.h"
#include "scatmap/base/error.h"
#include "scatmap/base/parallel.h"

namespace scatmap {
namespace fs = std::filesystem;
namespace {

constexpr const char* kModuleFile = "libscatmap_mrcal.so";

std::vector<fs::path> module_folders() {
  std::vector<fs::path> out;
  std::error_code failure;
  const fs::path program = fs::read_symlink("/proc/self/exe", failure);
  if (!failure) {
    out.push_back(program.parent_path());
    out.push_back(program.parent_path().parent_path() / "lib" / "scatmap");
  }
#ifdef SCATMAP_MODULE_FOLDERS
  for (const char* folder : {SCATMAP_MODULE_FOLDERS}) out.emplace_back(folder);
#endif
  return out;
}

// The module's functions. Opened once and never closed: mrcal is not made for unloading.
struct Module {
  decltype(&scatmap_lens_parse) parse = nullptr;
  decltype(&scatmap_lens_free) free = nullptr;
  decltype(&scatmap_lens_columns) columns = nullptr;
  decltype(&scatmap_lens_rows) rows = nullptr;
  decltype(&scatmap_lens_name) name = nullptr;
  decltype(&scatmap_lens_intrinsics) intrinsics = nullptr;
  decltype(&scatmap_lens_unproject) unproject = nullptr;
};

template <class Function>
void find_symbol(void* library, const char* name, const fs::path& file, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  if (function == nullptr)
    throw Error({file.string(), std::string("lacks ") + name + ": it belongs to another version of scatmap", {}, {}});
}

Module open_module(const fs::path& file) {
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr)
    throw Error({file.string(), "cannot be loaded", dlerror(), "mrcal's library: apt-get install libmrcal2"});
  Module m;
  find_symbol(library, "scatmap_lens_parse", file, m.parse);
  find_symbol(library, "scatmap_lens_free", file, m.free);
  find_symbol(library, "scatmap_lens_columns", file, m.columns);
  find_symbol(library, "scatmap_lens_rows", file, m.rows);
  find_symbol(library, "scatmap_lens_name", file, m.name);
  find_symbol(library, "scatmap_lens_intrinsics", file, m.intrinsics);
  find_symbol(library, "scatmap_lens_unproject", file, m.unproject);
  return m;
}

const Module& module() {
  static const Module kModule = [] {
    std::string looked;
    for (const fs::path& folder : module_folders()) {
      if (fs::exists(folder / kModuleFile)) return open_module(folder / kModuleFile);
      looked += (looked.empty() ? "" : ", ") + folder.string();
    }
    throw Error(
        {"detector.lens_cameramodel",
         std::string("needs the optional module ") + kModuleFile + ", which is in none of " + looked,
         {},
         "scatmap built where libmrcal-dev is installed (apt-get install --no-install-recommends libmrcal-dev)"});
  }();
  return kModule;
}

// mrcal says on standard error what it does not like. While this stands, that goes into `said`.
class StandardErrorCatcher {
 public:
  StandardErrorCatcher() : before_(dup(STDERR_FILENO)), caught_(std::tmpfile()) {
    if (before_ >= 0 && caught_ != nullptr) dup2(fileno(caught_), STDERR_FILENO);
  }
  StandardErrorCatcher(const StandardErrorCatcher&) = delete;
  StandardErrorCatcher& operator=(const StandardErrorCatcher&) = delete;
  ~StandardErrorCatcher() {
    restore();
    if (caught_ != nullptr) std::fclose(caught_);
  }
  /// The first line; nothing is caught after.
  std::string said() {
    restore();
    if (caught_ == nullptr) return {};
    std::rewind(caught_);
    std::string line;
    for (int c = std::fgetc(caught_); c != EOF && c != '\n'; c = std::fgetc(caught_)) line += static_cast<char>(c);
    return line;
  }

 private:
  void restore() {
    if (before_ < 0) return;
    dup2(before_, STDERR_FILENO);
    close(before_);
    before_ = -1;
  }
  int before_;
  std::FILE* caught_;
};

using Lens = std::unique_ptr<scatmap_lens, void (*)(scatmap_lens*)>;

Lens read_lens(const fs::path& path, int columns, int rows) {
  if (!fs::is_regular_file(path))
    throw Error({path.string(), "does not exist or is no file", {}, "an mrcal .cameramodel file"});
  const std::string text = to_cameramodel(read_lens_file(path));
  module();  // what is wrong with the module itself is no matter of the file
  StandardErrorCatcher mrcal;
  Lens lens(module().parse(text.c_str()), module().free);
  const std::string said = mrcal.said();
  if (!lens) throw Error({path.string(), "is no camera model that mrcal can read", said, "an mrcal .cameramodel file"});
  const int c = module().columns(lens.get()), r = module().rows(lens.get());
  if (c == columns && r == rows) return lens;
  throw Error({path.string() + ": imagersize", "is not the detector's size",
               std::to_string(c) + " x " + std::to_string(r), std::to_string(columns) + " x " + std::to_string(rows)});
}

// Unit rays of one row of positions first_column, first_column + 1, …; false if the model cannot do it.
bool unit_rays(const scatmap_lens* lens, double first_column, double row, std::vector<Vector3<double>>& out) {
  std::vector<double> positions(2 * out.size()), rays(3 * out.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    positions[2 * i] = first_column + static_cast<double>(i);
    positions[2 * i + 1] = row;
  }
  if (module().unproject(lens, positions.data(), out.size(), rays.data()) == 0) return false;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Vector3<double> ray(rays[3 * i], rays[3 * i + 1], rays[3 * i + 2]);
    out[i] = ray / ray.norm();
  }
  return true;
}

std::optional<OpencvLens> as_opencv(const scatmap_lens* lens) {
  std::array<double, 16> intrinsics{};  // LENSMODEL_OPENCV12 has 16; those with more are other models
  const std::size_t count = module().intrinsics(lens, intrinsics.data(), intrinsics.size());
  if (count > intrinsics.size()) return std::nullopt;
  return opencv_lens(module().name(lens), {intrinsics.data(), count});
}

void fill_rays(const OpencvLens& lens, LensRays& out) {
  const int columns = out.direction.columns();
  for_row_ranges(out.direction.rows(), [&](int first, int last) {
    std::vector<double> x(static_cast<std::size_t>(columns)), y(x.size());
    for (int r = first; r < last; ++r) {
      unproject_row(lens, r, {0, columns}, {x, y, out.solid_angle_sr.row(r)});
      for (std::size_t c = 0; c < x.size(); ++c)
        out.direction.row(r)[c] = Vector3<double>(x[c], y[c], 1) / std::sqrt(1 + x[c] * x[c] + y[c] * y[c]);
    }
  });
}

}  // namespace

LensRays load_lens_rays(const fs::path& cameramodel, int columns, int rows, LensInverse inverse) {
  const Lens lens = read_lens(cameramodel, columns, rows);
  LensRays out{module().name(lens.get()), {rows, columns}, {rows, columns}};
  const auto opencv = inverse == LensInverse::kFastest ? as_opencv(lens.get()) : std::nullopt;
  if (opencv) {
    fill_rays(*opencv, out);
    return out;
  }
  std::atomic<bool> failed{false};
  for_row_ranges(rows, [&](int first, int last) {
    const auto n = static_cast<std::size_t>(columns);
    std::vector<Vector3<double>> centres(n), sides(n + 1), above(n), below(n);
    if (!unit_rays(lens.get(), 0, first - 0.5, below)) failed = true;
    for (int r = first; r < last && !failed; ++r) {
      above.swap(below);
      const bool done = unit_rays(lens.get(), 0, r, centres) && unit_rays(lens.get(), -0.5, r, sides) &&
                        unit_rays(lens.get(), 0, r + 0.5, below);
      if (!done) failed = true;
      for (std::size_t c = 0; c < n; ++c) {
        out.direction.row(r)[c] = centres[c];
        out.solid_angle_sr.row(r)[c] = std::abs((sides[c + 1] - sides[c]).cross(below[c] - above[c]).dot(centres[c]));
      }
    }
  });
  if (failed) throw Error({cameramodel.string(), "has a lens model that mrcal cannot unproject", out.model, {}});
  return out;
}

AngleMap angle_map(const SampleView& view, const LensRays& rays) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const int rows = rays.direction.rows(), columns = rays.direction.columns();
  Matrix3<double> sample_from_camera;
  sample_from_camera << view.column_step.normalized(), view.row_step.normalized(), view.detector_normal;
  AngleMap map{incidence_angle(view), {rows, columns}, {rows, columns}, {rows, columns}, {rows, columns}};
  for_each_row(rows, [&](int r) {
    for (int c = 0; c < columns; ++c) {
      const Vector3<double> ray = sample_from_camera * rays.direction(r, c);
      Mask mask = 0;
      if (!std::isfinite(ray.squaredNorm()) || !std::isfinite(rays.solid_angle_sr(r, c)))
        mask = kNoData;
      else if (!(ray.z() > 0))
        mask = kBelowHorizon;
      map.theta_s_rad(r, c) = mask == 0 ? polar_angle(ray) : kNaN;
      map.phi_s_rad(r, c) = mask == 0 ? azimuth_from_minus_x(ray) : kNaN;
      map.solid_angle_sr(r, c) = mask == 0 ? rays.solid_angle_sr(r, c) : kNaN;
      map.mask(r, c) = mask;
    }
  });
  return map;
}

}  // namespace scatmap
