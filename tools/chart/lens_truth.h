#pragma once
#include <optional>
#include <string>

#include "scatmap/angles/opencv_lens.h"

namespace scatmap::tools {

/// A place on the sensor or on the plane z = 1.
struct LensPoint {
  long double x = 0, y = 0;
};

/// Pixel of the ray (x, y, 1), in long double; the first eight coefficients.
LensPoint projected(const OpencvLens& lens, long double x, long double y);

/// The ray of a pixel, in long double: from the lens's centre in small steps, so that no branch but the first is met.
/// Nothing where the lens folds back or a denominator passes 0 on the way.
std::optional<LensPoint> true_ray(const OpencvLens& lens, long double column, long double row);

/// As far as a unit in the last places of a ray moves its pixel.
double rounding_px(const OpencvLens& lens, const LensPoint& ray);
/// As far as a turn of the ray moves its pixel, at most.
double pixels_per_rad(const OpencvLens& lens, const LensPoint& ray);

/// The text of a .cameramodel, LENSMODEL_OPENCV8.
std::string cameramodel_of(const OpencvLens& lens, int columns, int rows);

}  // namespace scatmap::tools
