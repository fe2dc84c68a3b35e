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

bool is_near(const Segment& s) { return is_near_line(s.view.pixel(s.middle(), s.row), s.view.column_step, s.half()); }

template <class T>
kernel::NearSegment<T> near_segment(const Segment& s) {
  return near_segment<T>(reference_ray<ReferenceReal<T>>(s.view, s.middle(), s.row), s.view.column_step, s.columns.first - s.middle());
}

template <class T>
kernel::FarSegment<T> far_segment(const Segment& s) {
  return far_segment<T>(reference_ray<ReferenceReal<T>>(s.view, s.middle(), s.row), s.view.column_step, s.columns.first - s.middle());
}

constexpr int kShortest = 256;  // shorter parts cost more in references than they save
// d is exact in float32, and rounding of what changes along a part counts for little.
template <class T>
constexpr int kLongest = 4096;
template <>
constexpr int kLongest<float> = kSinglePart;

template <class T>
void write_angles(const Segment& s, T* theta, T* phi) {
  const auto n = static_cast<std::size_t>(s.columns.size());
  if (s.columns.size() <= kLongest<T> && is_near(s)) {
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
  const Wide r = reference_ray(s.view, s.middle(), s.row).length();
  const Vector3<double>&n = s.view.detector_normal, &o = s.view.origin;
  const Wide facing = Wide(n.x()) * o.x() + Wide(n.y()) * o.y() + Wide(n.z()) * o.z();
  return static_cast<T>(s.view.pixel_area_m2 * facing / (r * r * r));
}

template <class T>
void write_visible(const Segment& whole, const AngleRow<T>& out, std::size_t offset) {
  const auto at = [](std::span<T> span, std::size_t i) { return span.data() + i; };
  for (int first = whole.columns.first; first < whole.columns.last; first += kLongest<T>) {
    const Segment s{whole.view, whole.row, {first, std::min(first + kLongest<T>, whole.columns.last)}};
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
