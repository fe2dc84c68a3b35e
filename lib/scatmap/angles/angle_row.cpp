#include "scatmap/angles/angle_row.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scatmap/angles/angle_line.h"

namespace scatmap {
namespace {

// A part of a row with its reference pixel at the middle.
struct Segment {
  const SampleView& view;
  int row;
  ColumnRange columns;
  double middle() const { return 0.5 * (columns.first + columns.last - 1); }
  double half() const { return 0.5 * (columns.size() - 1); }
};

// Whether every pixel lies so near the reference that small_arctangent serves for both angles, with phi off the seam.
bool is_near(const Segment& s) {
  constexpr double kRange = 0.999 * kSmallArctangentRange, kSeam = 1e-6;  // more than float32 rounds
  const Vector3<double> p = s.view.pixel(s.middle(), s.row);
  const Vector3<double>& u = s.view.column_step;
  const double h = s.half(), rho2 = p.x() * p.x() + p.y() * p.y();
  // |tan| of the angle between two directions is |a × b|/a·b; theta changes by no more than the direction.
  const double turn = h * std::abs(p.x() * u.y() - p.y() * u.x());
  const double flat = rho2 - h * std::abs(p.x() * u.x() + p.y() * u.y());
  const double way = h * p.cross(u).norm(), along = p.squaredNorm() - h * std::abs(p.dot(u));
  // Half way to the pole and farther, rho² = rho_ref² + rise loses digits; and in float32 rho² must not vanish.
  if (!(flat >= 0.5 * rho2 && rho2 > 1e-12 * p.squaredNorm())) return false;
  if (!(turn <= kRange * flat && way <= kRange * along)) return false;
  // The seam lies at y = 0, x < 0.
  return p.x() > 0 || std::abs(p.y()) * flat > turn * std::sqrt(rho2) + kSeam * rho2 * std::sqrt(rho2);
}

template <class T>
kernel::NearSegment<T> near_segment(const Segment& s) {
  const WideRay p = wide_ray(s.view, s.middle(), s.row);
  const Vector3<double>& u = s.view.column_step;
  const Wide rho2 = p.x * p.x + p.y * p.y, r2 = rho2 + p.z * p.z, rho = std::sqrt(rho2), r = std::sqrt(r2);
  const Wide across = p.x * u.y() - p.y * u.x(), along = p.x * u.x() + p.y * u.y();
  const TwoParts<T> phi(std::atan2(p.y, p.x) + std::numbers::pi_v<Wide>), theta(std::atan2(rho, p.z));
  kernel::NearSegment<T> out;
  out.first_d = static_cast<T>(s.columns.first - s.middle());
  out.phi = phi.high;
  out.phi_rest = phi.rest;
  out.theta = theta.high;
  out.theta_rest = theta.rest;
  out.turn = static_cast<T>(across / rho2);
  out.stretch = static_cast<T>(along / rho2);
  out.rho = static_cast<T>(rho / r);
  out.z = static_cast<T>(p.z / r);
  out.rho2_linear = static_cast<T>(2 * along / r2);
  out.rho2_square = static_cast<T>((Wide(u.x()) * u.x() + Wide(u.y()) * u.y()) / r2);
  out.z_step = static_cast<T>(u.z() / r);
  return out;
}

template <class T>
kernel::FarSegment<T> far_segment(const Segment& s) {
  return far_segment<T>(wide_ray(s.view, s.middle(), s.row), s.view.column_step, s.columns.first - s.middle());
}

constexpr int kShortest = 256;  // shorter parts cost more in references than they save
constexpr int kLongest = 4096;  // d is exact in float32, and rounding of the step counts for little

template <class T>
void write_angles(const Segment& s, T* theta, T* phi) {
  const auto n = static_cast<std::size_t>(s.columns.size());
  if (s.columns.size() <= kLongest && is_near(s)) {
    kernel::run_near(near_segment<T>(s), n, theta, phi);
  } else if (s.columns.size() <= kShortest) {
    kernel::run_far(far_segment<T>(s), n, theta, phi);
  } else {
    const int middle = s.columns.first + s.columns.size() / 2;
    const auto left = static_cast<std::size_t>(middle - s.columns.first);
    write_angles<T>({s.view, s.row, {s.columns.first, middle}}, theta, phi);
    write_angles<T>({s.view, s.row, {middle, s.columns.last}}, theta + left, phi + left);
  }
}

// area·|facing|/r³ with lengths in units of the reference ray's length.
template <class T>
T solid_angle_scale(const Segment& s) {
  const Wide r = wide_ray(s.view, s.middle(), s.row).length();
  const Vector3<double>&n = s.view.detector_normal, &o = s.view.origin;
  const Wide facing = Wide(n.x()) * o.x() + Wide(n.y()) * o.y() + Wide(n.z()) * o.z();
  return static_cast<T>(s.view.pixel_area_m2 * facing / (r * r * r));
}

template <class T>
void write_visible(const Segment& whole, const AngleRow<T>& out, std::size_t offset) {
  const auto at = [](std::span<T> span, std::size_t i) { return span.data() + i; };
  for (int first = whole.columns.first; first < whole.columns.last; first += kLongest) {
    const Segment s{whole.view, whole.row, {first, std::min(first + kLongest, whole.columns.last)}};
    const auto n = static_cast<std::size_t>(s.columns.size());
    const std::size_t i = offset + static_cast<std::size_t>(first - whole.columns.first);
    if (!out.theta_s_rad.empty()) write_angles<T>(s, at(out.theta_s_rad, i), at(out.phi_s_rad, i));
    if (!out.solid_angle_sr.empty())
      kernel::run_solid_angles(far_segment<T>(s), solid_angle_scale<T>(s), n, at(out.solid_angle_sr, i));
    if (!out.cos_theta_s.empty()) kernel::run_cosines(far_segment<T>(s), n, at(out.cos_theta_s, i));
    if (!out.projected_solid_angle_sr.empty())
      kernel::run_projected(far_segment<T>(s), solid_angle_scale<T>(s), n, at(out.projected_solid_angle_sr, i));
  }
}

// Every place outside [begin, end).
template <class T>
void fill_outside(std::span<T> span, std::size_t begin, std::size_t end, T value) {
  if (span.empty()) return;
  std::fill(span.begin(), span.begin() + static_cast<std::ptrdiff_t>(begin), value);
  std::fill(span.begin() + static_cast<std::ptrdiff_t>(end), span.end(), value);
}

bool behind_detector(const SampleView& view) { return !(view.detector_normal.dot(view.origin) > 0); }

void write_mask(const SampleView& view, int row, ColumnRange columns, ColumnRange visible, std::span<Mask> mask) {
  if (mask.empty()) return;
  std::fill(mask.begin(), mask.end(), Mask{0});
  if (visible.size() == columns.size()) return;
  for (int c = columns.first; c < columns.last; ++c) {
    if (c >= visible.first && c < visible.last) continue;
    Mask& m = mask[static_cast<std::size_t>(c - columns.first)];
    if (!(view.pixel(c, row).z() > 0)) m |= kBelowHorizon;
    if (behind_detector(view)) m |= kBehindDetector;
  }
}

template <class T>
void write_row(const SampleView& view, int row, ColumnRange columns, const AngleRow<T>& out) {
  const ColumnRange visible = visible_columns(view, row, columns);
  const auto begin = static_cast<std::size_t>(visible.first - columns.first),
             end = static_cast<std::size_t>(visible.last - columns.first);
  for (const std::span<T> span :
       {out.theta_s_rad, out.phi_s_rad, out.solid_angle_sr, out.cos_theta_s, out.projected_solid_angle_sr})
    fill_outside(span, begin, end, std::numeric_limits<T>::quiet_NaN());
  write_mask(view, row, columns, visible, out.mask);
  write_visible<T>({view, row, visible}, out, begin);
}

}  // namespace

ColumnRange visible_columns(const SampleView& view, int row, ColumnRange columns) {
  if (behind_detector(view)) return {columns.first, columns.first};
  const auto above = [&](int c) { return view.pixel(c, row).z() > 0; };
  if (columns.size() <= 0) return columns;
  const bool first = above(columns.first), last = above(columns.last - 1);
  if (first && last) return columns;
  if (!first && !last) return {columns.first, columns.first};
  // z grows or falls along the row: one crossing, found by halving.
  int low = columns.first, high = columns.last - 1;
  while (high - low > 1) {
    const int middle = low + (high - low) / 2;
    (above(middle) == first ? low : high) = middle;
  }
  return first ? ColumnRange{columns.first, high} : ColumnRange{high, columns.last};
}

void angle_row(const SampleView& view, int row, ColumnRange columns, const AngleRow<double>& out) {
  write_row(view, row, columns, out);
}

void angle_row(const SampleView& view, int row, ColumnRange columns, const AngleRow<float>& out) {
  write_row(view, row, columns, out);
}

}  // namespace scatmap
