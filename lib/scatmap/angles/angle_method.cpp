#include "scatmap/angles/angle_method.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "scatmap/angles/angle_row.h"
#include "scatmap/angles/direction_pixels.h"
#include "scatmap/angles/frame_extent.h"
#include "scatmap/angles/linear_map.h"
#include "scatmap/angles/opencv_lens.h"
#include "scatmap/base/parallel.h"

namespace scatmap {
namespace {

constexpr std::array kMethods{AngleMethod::kLinear, AngleMethod::kTile, AngleMethod::kSingle, AngleMethod::kVector,
                              AngleMethod::kExact};
constexpr std::array<std::string_view, 5> kNames{"linear", "tile", "single", "vector", "exact"};

template <class T>
void write_rows(const SampleView& view, AngleMapOf<T>& map) {
  const int rows = map.theta_s_rad.rows(), columns = map.theta_s_rad.columns();
  map.theta_i_rad = incidence_angle(view);
  for_each_row(rows, [&](int r) {
    AngleRow<T> out;
    out.theta_s_rad = map.theta_s_rad.row(r);
    out.phi_s_rad = map.phi_s_rad.row(r);
    if (!map.solid_angle_sr.empty()) out.solid_angle_sr = map.solid_angle_sr.row(r);
    if (!map.mask.empty()) out.mask = map.mask.row(r);
    angle_row(view, r, {0, columns}, out);
  });
}

// A pixel at a time with the C library, the plainest text.
void write_exact(const SampleView& view, AngleMap& map) {
  map.theta_i_rad = incidence_angle(view);
  for_each_row(map.theta_s_rad.rows(), [&](int r) {
    for (int c = 0; c < map.theta_s_rad.columns(); ++c) {
      const PixelAngles a = pixel_angles(view, c, r);
      map.theta_s_rad(r, c) = a.theta_s_rad;
      map.phi_s_rad(r, c) = a.phi_s_rad;
      if (!map.solid_angle_sr.empty()) map.solid_angle_sr(r, c) = a.solid_angle_sr;
      if (!map.mask.empty()) map.mask(r, c) = a.mask;
    }
  });
}

// The tiles get what the tolerance leaves beyond the rounding to float32, if that is worth anything.
AngleChoice tile_choice(const SampleView& view, int rows, int columns, double tolerance_rad, double single_rad) {
  constexpr double kWorth_rad = 1e-9;
  const double truncation = std::max(tolerance_rad - single_rad, kWorth_rad);
  return {AngleMethod::kTile, single_rad + truncation, 0, plan_tiles<float>(view, rows, columns, truncation)};
}

}  // namespace

std::string_view to_string(AngleMethod method) { return kNames[static_cast<std::size_t>(method)]; }

std::optional<AngleMethod> angle_method(std::string_view name) {
  const auto at = std::find(kNames.begin(), kNames.end(), name);
  if (at == kNames.end()) return std::nullopt;
  return static_cast<AngleMethod>(at - kNames.begin());
}

std::span<const AngleMethod> angle_methods() { return kMethods; }

AngleChoice with_method(AngleMethod method, const SampleView& view, int rows, int columns, double tolerance_px) {
  const FrameExtent extent = frame_extent(view, rows, columns);
  const double single_rad = single_bound_rad(extent, view, columns);
  AngleChoice choice{method, vector_bound_rad(extent), 0, {}};
  if (method == AngleMethod::kVector) choice.tiles = plan_tiles<double>(view, rows, columns, kVectorTruncation_rad);
  if (method == AngleMethod::kExact) choice.bound_rad = exact_bound_rad(extent);
  if (method == AngleMethod::kSingle) choice.bound_rad = single_rad;
  if (method == AngleMethod::kLinear) choice.bound_rad = linear_bound_rad(view, rows, columns);
  if (method == AngleMethod::kTile)
    choice = tile_choice(view, rows, columns, tolerance_px * extent.pixel_step_rad, single_rad);
  choice.bound_px = choice.bound_rad / extent.pixel_step_rad;
  return choice;
}

AngleChoice choose_angle_method(const SampleView& view, int rows, int columns, double tolerance_px) {
  for (const AngleMethod method : kMethods) {
    // A hair of room: tile's bound is the tolerance itself, up to rounding.
    const AngleChoice choice = with_method(method, view, rows, columns, tolerance_px);
    constexpr double kRounding = 1e-12;
    const bool tiles_help = method != AngleMethod::kTile || choice.tiles.polynomial_share > 0.5;
    if (choice.bound_px <= tolerance_px * (1 + kRounding) && tiles_help) return choice;
  }
  return with_method(AngleMethod::kVector, view, rows, columns, tolerance_px);
}

void write_angle_map(const SampleView& view, const AngleChoice& choice, AngleMap& map) {
  if (choice.method == AngleMethod::kExact)
    write_exact(view, map);
  else if (choice.tiles.polynomial_share > 0)
    write_tile_map(view, choice.tiles, map);
  else
    write_rows(view, map);
}

void write_angle_map(const SampleView& view, const AngleChoice& choice, AngleMapOf<float>& map) {
  if (choice.method == AngleMethod::kLinear)
    write_linear_map(view, map);
  else if (choice.method == AngleMethod::kTile)
    write_tile_map(view, choice.tiles, map);
  else
    write_rows(view, map);
}

std::span<const MethodBound> angle_bounds() {
  static constexpr const char* kDomain = "any frame; times farthest over nearest pixel distance";
  static constexpr const char* kReference = "long double, the same view";
  static constexpr std::array kBounds{
      MethodBound{"angles", "exact", "direction", kReference, kDomain, "rad", kExactMaxError_rad},
      MethodBound{"angles", "exact", "direction", "simulator's long double", "random benches", "rad",
                  kAngleMaxError_rad},
      MethodBound{"angles", "exact", "solid angle", kReference, kDomain, "relative", kRowSolidAngleMaxError},
      MethodBound{"angles", "vector", "direction", kReference, kDomain, "rad", kVectorMaxError_rad},
      MethodBound{"angles", "vector", "solid angle", kReference, kDomain, "relative", kRowSolidAngleMaxError},
      MethodBound{"angles", "vector", "cos theta", kReference, kDomain, "1", kRowCosineMaxError},
      MethodBound{"angles", "single", "direction", kReference, kDomain, "rad", kSingleMaxError_rad},
      MethodBound{"angles", "single", "solid angle", kReference, kDomain, "relative", kSingleSolidAngleMaxError},
      MethodBound{"angles", "single", "cos theta", kReference, kDomain, "1", kSingleCosineMaxError},
      MethodBound{"inverse", "vector", "direction", "long double, the same view", kDomain, "rad", kInverseMaxError_rad},
      MethodBound{"lens", "Newton", "ray", "forward model in long double", "OPENCV4, 5, 8 and 12", "px",
                  kLensMaxError_px},
  };
  return kBounds;
}

}  // namespace scatmap
