#pragma once
#include "scatmap/angles/instrument.h"
#include "scatmap/angles/pixel_plane.h"
#include "scatmap/base/grid.h"
#include "scatmap/base/mask.h"

namespace scatmap {

/// Per pixel: where the light that reaches it left the sample.
template <class T>
struct AngleMapOf {
  double theta_i_rad = 0;  ///< between sample normal and the direction to the source; phi_i = 0
  Grid<T> theta_s_rad;     ///< [0, pi/2)
  Grid<T> phi_s_rad;       ///< from −x, [0, 2 pi): specular is pi
  Grid<T> solid_angle_sr;  ///< of one pixel seen from the spot
  Grid<Mask> mask;         ///< kBelowHorizon, kBehindDetector; the pixel's numbers are then NaN
};

using AngleMap = AngleMapOf<double>;

struct PixelAngles {
  double theta_s_rad;
  double phi_s_rad;
  double solid_angle_sr;  ///< pixel area × cos(incidence on the detector) / distance²
  Mask mask;              ///< not 0: the numbers are NaN
};

/// Angles of one pixel position, which may be fractional or off the array.
PixelAngles pixel_angles(const SampleView& view, double column, double row);

/// What maps use: the `vector` method (angle_method.h), within kVectorMaxError_rad of direction (angle_row.h) on the same
/// view and kAngleMaxError_rad from the numbers of the instrument file, kSolidAngleMaxError relative.
/// With a lens (Instrument::lens_cameramodel) the rays are mrcal's, to the tolerance of its solver (1e-6 px for models
/// that are inverted by iteration), and the solid angles are differences over one pixel.
/// @throws Error from sample_view and load_lens_rays
AngleMap angle_map(const Instrument& instrument, const Pose& pose);

/// The `exact` method: double throughout, a pixel at a time with the C library; the reference. Error against long
/// double: kExactMaxError_rad of direction on the same view, kAngleMaxError_rad from the numbers of the instrument file,
/// kSolidAngleMaxError relative.
AngleMap angle_map(const SampleView& view, int rows, int columns);

/// Times farthest over nearest pixel distance, over sin(theta_i): at normal incidence phi has no zero.
inline constexpr double kAngleMaxError_rad = 2e-15;
/// Of theta and sin(theta)·phi, root of squares, times farthest over nearest pixel distance: without the rounding that
/// went into the view.
inline constexpr double kExactMaxError_rad = 1e-15;
inline constexpr double kSolidAngleMaxError = 1e-12;

/// Direction of a pixel position, which may be fractional, from the angles of the four pixels around it: unit, sample
/// axes, bilinear. For detectors behind a lens, whose rays have no closed form; off by at most an eighth of the rays'
/// second difference over one pixel. NaN off the array and beside pixels without angles.
Vector3<double> interpolated_direction(const AngleMap& map, PixelPosition at);

}  // namespace scatmap
