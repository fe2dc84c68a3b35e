#include "tools/chart/lens_truth.h"

#include <cmath>
#include <limits>

#include "scatmap/base/number_text.h"

namespace scatmap::tools {
namespace {

struct Slopes {
  long double xx, xy, yx, yy;
  long double determinant() const { return xx * yy - xy * yx; }
};

long double top(const OpencvLens& l, long double r2) { return 1 + r2 * (l.k[0] + r2 * (l.k[1] + r2 * l.k[4])); }
long double bottom(const OpencvLens& l, long double r2) { return 1 + r2 * (l.k[5] + r2 * (l.k[6] + r2 * l.k[7])); }

// Of the pixel in focal lengths by the ray.
Slopes slopes(const OpencvLens& l, long double x, long double y) {
  const auto& k = l.k;
  const long double r2 = x * x + y * y, b = bottom(l, r2), radial = top(l, r2) / b;
  const long double by_r2 =
      (k[0] + r2 * (2 * k[1] + 3 * r2 * k[4]) - radial * (k[5] + r2 * (2 * k[6] + 3 * r2 * k[7]))) / b;
  const long double mixed = 2 * x * y * by_r2 + 2 * k[2] * x + 2 * k[3] * y;
  return {radial + 2 * x * x * by_r2 + 2 * k[2] * y + 6 * k[3] * x, mixed, mixed,
          radial + 2 * y * y * by_r2 + 6 * k[2] * y + 2 * k[3] * x};
}

bool unfolded(const OpencvLens& l, const LensPoint& p) {
  const Slopes s = slopes(l, p.x, p.y);
  return bottom(l, p.x * p.x + p.y * p.y) > 0 && s.determinant() > 0 && s.xx + s.yy > 0;
}

// All the way: a step may not jump over a fold.
bool unfolded_between(const OpencvLens& l, const LensPoint& a, const LensPoint& b) {
  constexpr int kParts = 8;
  for (int i = 1; i <= kParts; ++i) {
    const long double share = static_cast<long double>(i) / kParts;
    if (!unfolded(l, {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)})) return false;
  }
  return true;
}

}  // namespace

LensPoint projected(const OpencvLens& l, long double x, long double y) {
  const auto& k = l.k;
  const long double r2 = x * x + y * y, radial = top(l, r2) / bottom(l, r2);
  return {l.fx * (x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x)) + l.cx,
          l.fy * (y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y) + l.cy};
}

namespace {

// Newton's method from a ray nearby; nothing where it does not meet the pixel or jumps over a fold.
std::optional<LensPoint> near_ray(const OpencvLens& l, const LensPoint& pixel, const LensPoint& from) {
  constexpr int kMost = 60;
  constexpr long double kMet = 1e-17L, kFocal = 1e-9L;  // of the ray; of the focal length
  LensPoint ray = from;
  for (int k = 0; k < kMost; ++k) {
    const LensPoint at = projected(l, ray.x, ray.y);
    const long double ex = (pixel.x - at.x) / l.fx, ey = (pixel.y - at.y) / l.fy;
    const Slopes s = slopes(l, ray.x, ray.y);
    const LensPoint step{(s.yy * ex - s.xy * ey) / s.determinant(), (s.xx * ey - s.yx * ex) / s.determinant()};
    ray.x += step.x;
    ray.y += step.y;
    if (std::hypot(step.x, step.y) <= kMet * std::hypot(ray.x, ray.y)) break;
  }
  const LensPoint at = projected(l, ray.x, ray.y);
  const bool met =
      std::hypot((pixel.x - at.x) / l.fx, (pixel.y - at.y) / l.fy) <= kFocal * (1 + std::hypot(ray.x, ray.y));
  if (!met || !unfolded_between(l, from, ray)) return std::nullopt;
  return ray;
}

}  // namespace

std::optional<LensPoint> true_ray(const OpencvLens& l, long double column, long double row) {
  constexpr int kSteps = 40;
  std::optional<LensPoint> ray = LensPoint{};
  for (int i = 1; i <= kSteps && ray; ++i) {
    const long double share = static_cast<long double>(i) / kSteps;
    ray = near_ray(l, {l.cx + share * (column - l.cx), l.cy + share * (row - l.cy)}, *ray);
  }
  return ray;
}

double rounding_px(const OpencvLens& l, const LensPoint& ray) {
  const Slopes s = slopes(l, ray.x, ray.y);
  const long double across = l.fx * (std::abs(s.xx * ray.x) + std::abs(s.xy * ray.y)),
                    down = l.fy * (std::abs(s.yx * ray.x) + std::abs(s.yy * ray.y));
  return std::numeric_limits<double>::epsilon() * static_cast<double>(std::hypot(across, down));
}

double pixels_per_rad(const OpencvLens& l, const LensPoint& ray) {
  const Slopes s = slopes(l, ray.x, ray.y);
  const long double largest = std::hypot(std::hypot(l.fx * s.xx, l.fx * s.xy), std::hypot(l.fy * s.yx, l.fy * s.yy));
  return static_cast<double>((1 + ray.x * ray.x + ray.y * ray.y) * largest);
}

std::string cameramodel_of(const OpencvLens& lens, int columns, int rows) {
  std::string intrinsics;
  for (const double v : {lens.fx, lens.fy, lens.cx, lens.cy}) intrinsics += number_text(v) + ", ";
  for (std::size_t i = 0; i < 8; ++i) intrinsics += number_text(lens.k[i]) + ", ";
  return "{ 'lensmodel': 'LENSMODEL_OPENCV8', 'extrinsics': [0, 0, 0, 0, 0, 0], 'intrinsics': [" + intrinsics +
         "], 'imagersize': [" + std::to_string(columns) + ", " + std::to_string(rows) + "] }\n";
}

}  // namespace scatmap::tools
