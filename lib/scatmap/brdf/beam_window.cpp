#include "scatmap/brdf/beam_window.h"

#include <algorithm>
#include <cmath>

namespace scatmap {
namespace {

template <class T>
Grid<T> part(const Grid<T>& of, const FrameWindow& w) {
  Grid<T> out(w.rows, w.columns);
  for (int r = 0; r < w.rows; ++r) std::copy_n(&of(w.row + r, w.column), w.columns, out.row(r).data());
  return out;
}

}  // namespace

FrameWindow beam_window(const Signature& beam, int frame_rows, int frame_columns) {
  const double reach = background_radius_px(beam.radius_px);
  const auto first = [&](double centre, int size) {
    return static_cast<int>(std::clamp(std::floor(centre - reach), 0.0, size - 1.0));
  };
  const auto last = [&](double centre, int size) {
    return static_cast<int>(std::clamp(std::ceil(centre + reach), 0.0, size - 1.0));
  };
  const int row = first(beam.row, frame_rows), column = first(beam.column, frame_columns);
  return {row, column, last(beam.row, frame_rows) - row + 1, last(beam.column, frame_columns) - column + 1};
}

Counts cropped(const Counts& c, const FrameWindow& w) {
  return {part(c.rate_dn_per_s, w), part(c.frame_floor, w), part(c.shot, w),    part(c.dark_floor, w),
          part(c.mask, w),          c.exposure_s,           c.saturated_pixels, c.rejected_values};
}

}  // namespace scatmap
