#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "scatmap/angles/angle_map.h"
#include "scatmap/angles/tile_map.h"
#include "scatmap/base/method_bound.h"

namespace scatmap {

/// Methods of the angle map, from the fastest to the most plain. The first three fill float32 maps.
enum class AngleMethod { kLinear, kTile, kSingle, kVector, kExact };

std::string_view to_string(AngleMethod method);
std::optional<AngleMethod> angle_method(std::string_view name);
std::span<const AngleMethod> angle_methods();
constexpr bool fills_single(AngleMethod method) { return method <= AngleMethod::kSingle; }

/// A method with its bound on one frame.
struct AngleChoice {
  AngleMethod method = AngleMethod::kVector;
  double bound_rad = 0;  ///< of the direction: theta and sin(theta)·phi, root of squares
  double bound_px = 0;   ///< the same over the frame's finest pixel step
  TilePlan tiles;        ///< kTile and kVector
};

/// The method's bound on the frame. @param tolerance_px what `tile` may take; the others do not read it
AngleChoice with_method(AngleMethod method, const SampleView& view, int rows, int columns, double tolerance_px);

/// The fastest method whose bound is at most tolerance_px; `vector` if none is.
AngleChoice choose_angle_method(const SampleView& view, int rows, int columns, double tolerance_px);

/// Fills the maps that are not empty, theta and phi always, without allocating: buffers can be used again. All of a
/// map's grids have the shape of theta_s_rad. @pre fills_single(choice.method) is false
void write_angle_map(const SampleView& view, const AngleChoice& choice, AngleMap& map);
/// @pre fills_single(choice.method)
void write_angle_map(const SampleView& view, const AngleChoice& choice, AngleMapOf<float>& map);

/// Without a calibration's uncertainty, directions are computed to this.
inline constexpr double kDefaultTolerance_px = 0.001;
/// With one, to this share of it.
inline constexpr double kToleranceShare = 0.1;

/// The promises of this room's methods, with the inverse and the lens. The bounds of `tile` and `linear` belong to a
/// frame: with_method.
std::span<const MethodBound> angle_bounds();

}  // namespace scatmap
