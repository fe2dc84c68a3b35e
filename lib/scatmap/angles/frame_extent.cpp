#include "scatmap/angles/frame_extent.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scatmap/angles/angle_map.h"
#include "scatmap/angles/angle_row.h"
#include "scatmap/base/arctangent.h"

namespace scatmap {
namespace {

constexpr double kPi = std::numbers::pi;

struct Corners {
  double farthest_m = 0, radius_rad = 0;
};

// Directions within an angle of the middle one cut the detector plane in a conic that holds, with the corners, all
// pixels between them; so does a sphere about the spot.
Corners corners(const SampleView& view, int rows, int columns, const Vector3<double>& middle) {
  Corners out;
  for (const int row : {0, rows - 1}) {
    for (const int column : {0, columns - 1}) {
      const Vector3<double> corner = view.pixel(column, row);
      out.farthest_m = std::max(out.farthest_m, corner.norm());
      out.radius_rad = std::max(out.radius_rad, angle_between(middle, corner));
    }
  }
  return out;
}

// The frame's axes are at right angles: its nearest point is the foot of the perpendicular, held inside.
double nearest_m(const SampleView& view, int rows, int columns) {
  const auto foot = [&](const Vector3<double>& step, int count) {
    return std::clamp(-view.origin.dot(step) / step.squaredNorm(), 0.0, static_cast<double>(count - 1));
  };
  return view.pixel(foot(view.column_step, columns), foot(view.row_step, rows)).norm();
}

double half_ulp(double value) {
  const auto f = static_cast<float>(value);
  return 0.5 * (static_cast<double>(std::nextafter(f, std::numeric_limits<float>::max())) - static_cast<double>(f));
}

// Of the largest angles to float32.
double rounding_rad(const FrameExtent& e) {
  return std::hypot(half_ulp(e.theta_max_rad), half_ulp(e.phi_max_rad) * std::sin(e.theta_max_rad));
}

}  // namespace

FrameExtent frame_extent(const SampleView& view, int rows, int columns) {
  const Vector3<double> middle = view.pixel(0.5 * (columns - 1), 0.5 * (rows - 1));
  const Corners far = corners(view, rows, columns, middle);
  FrameExtent out;
  out.radius_rad = far.radius_rad;
  const double theta = polar_angle(middle), phi = azimuth_from_minus_x(middle);
  out.theta_min_rad = std::max(0.0, theta - far.radius_rad);
  out.theta_max_rad = std::min(kPi / 2, theta + far.radius_rad);
  const bool off_pole = theta > far.radius_rad && theta + far.radius_rad < kPi && far.radius_rad < kPi / 2;
  // A cap of this radius about the middle spans sin(phi) = sin(radius)/sin(theta) on either side.
  const double half_width = std::sin(far.radius_rad),
               rest = std::sin(theta + far.radius_rad) * std::sin(theta - far.radius_rad);
  const double phi_radius = off_pole && rest > 0 ? std::atan2(half_width, std::sqrt(rest)) : kPi;
  constexpr double kSeam = 1e-6;
  out.off_seam = phi - phi_radius > 2 * kSeam && phi + phi_radius < 2 * kPi - 2 * kSeam;
  out.phi_max_rad = out.off_seam ? phi + phi_radius : 2 * kPi;
  const double plane_m = std::abs(view.detector_normal.dot(view.origin));
  out.nearest_m = nearest_m(view, rows, columns);
  out.spread = far.farthest_m / out.nearest_m;
  // At incidence psi on the detector a step s at distance r turns the ray by at least s cos(psi)/r, cos(psi) = plane/r.
  out.pixel_step_rad =
      std::min(view.column_step.norm(), view.row_step.norm()) * plane_m / (far.farthest_m * far.farthest_m);
  return out;
}

double exact_bound_rad(const FrameExtent& e) { return kExactMaxError_rad * e.spread; }
double vector_bound_rad(const FrameExtent& e) { return kVectorMaxError_rad * e.spread; }

double single_bound_rad(const FrameExtent& e, const SampleView& view, int columns) {
  const double step_rad = view.column_step.norm() / e.nearest_m;  // at most
  // Parts of rows that angle_row never takes for far from their reference, whatever its choice: 128 columns and less.
  constexpr double kHalfPart = 128;
  const double reach = kHalfPart * step_rad;
  const bool near =
      e.off_seam && reach + reach * kSmallArctangentRange < 0.9 * kSmallArctangentRange * std::sin(e.theta_min_rad);
  if (!near) return linear_rounding_rad(e);
  const double half_part = 0.5 * std::min(columns, kSinglePart) * step_rad;
  return rounding_rad(e) + std::min(kSingleArithmetic * half_part, kSingleArithmetic_rad);
}

double linear_rounding_rad(const FrameExtent& e) { return rounding_rad(e) + kSingleFarArithmetic_rad * e.spread; }

}  // namespace scatmap
