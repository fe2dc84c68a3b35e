#include "scatmap/brdf/fused.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "scatmap/base/parallel.h"
#include "scatmap/brdf/fused_kernels.h"
#include "scatmap/brdf/pose_kernels.h"

namespace scatmap {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// The last few rows of something, the oldest overwritten; `margin` elements on either side keep the value `edge`.
template <class T, int kRows>
class RowRing {
 public:
  RowRing(int columns, int margin, T edge)
      : stride_((static_cast<std::size_t>(columns) + 2 * static_cast<std::size_t>(margin) + 63) / 64 * 64),
        margin_(static_cast<std::size_t>(margin)),
        columns_(columns),
        edge_(edge),
        data_(stride_ * kRows, edge) {}
  T* at(int row) { return data_.data() + static_cast<std::size_t>(row + kRows) % kRows * stride_ + margin_; }
  void clear(int row) { std::fill_n(at(row), columns_, edge_); }

 private:
  std::size_t stride_, margin_;
  int columns_;
  T edge_;
  std::vector<T, HugePageAllocator<T>> data_;
};

// One band of rows, streamed: row r is reduced; r − 1 then knows its blooming neighbours; r − 3 its window; r − 4 its
// gradient.
class Band {
 public:
  Band(const RowReducer& reducer, const FusedGeometry& geometry, FusedPlanes& out)
      : reducer_(reducer),
        geometry_(geometry),
        out_(out),
        rows_(out.mask.rows()),
        columns_(out.mask.columns()),
        unused_f_(static_cast<std::size_t>(columns_)),
        unused_u_(unused_f_.size()) {}

  void run(int index) {
    first_ = index * kFusedBand;
    last_ = std::min(rows_, first_ + kFusedBand);
    if (geometry_.pose != nullptr) tiles_ = geometry_.pose->band(index);
    constexpr int kBloom1 = 1, kGradient = 1;
    const int window_first = first_ - kGradient - kWindowReach, window_last = last_ + kGradient + kWindowReach;
    for (int row = window_first - kBloom1; row < window_last + kBloom1; ++row) {
      next_row_ = row + 1;
      asked_ = on_frame(next_row_) ? 0 : columns_;
      reduce_row(row);
      ask_for_more();
      if (row - 1 >= window_first) clean(row - 1);
      ask_for_more();
      const int middle = row - 1 - kWindowReach;
      if (middle >= first_ - kGradient) finish(middle);
      ask_for_more();
      if (middle - kGradient >= first_) add_pose(middle - kGradient);
    }
  }

 private:
  bool on_frame(int row) const { return row >= 0 && row < rows_; }
  CleanRow at(int row) { return {value_.at(row), floor_.at(row), shot_.at(row)}; }
  bool in_band(int row) const { return row >= first_ && row < last_; }

  // Some more of the next row's inputs are on their way while this one is worked on.
  void ask_for_more() {
    if (asked_ >= columns_) return;
    reducer_.prefetch(next_row_, asked_);
    asked_ += RowReducer::kAhead;
  }

  void reduce_row(int row) {
    if (!on_frame(row)) {
      mask_.clear(row);
      return;
    }
    reducer_.row(row, {value_.at(row), floor_.at(row), shot_.at(row), nullptr, mask_.at(row)}, scratch_);
    spills_.at(static_cast<std::size_t>(row + 3) % 3) =
        spills_charge({mask_.at(row), static_cast<std::size_t>(columns_)});
  }

  void clean(int row) {
    if (!on_frame(row)) {
      value_.clear(row);
      good_.clear(row);
      return;
    }
    const auto width = static_cast<std::size_t>(columns_);
    for (const int from : {row - 1, row, row + 1}) {
      if (on_frame(from) && spills_.at(static_cast<std::size_t>(from + 3) % 3))
        mark_bloom({mask_.at(from), width}, {mask_.at(row), width});
    }
    odd_.at(static_cast<std::size_t>(row) % kWindowRows) = clean_row(mask_.at(row), columns_, at(row), good_.at(row));
  }

  // A row's map; rows beside the band only for the gradient.
  void finish(int row) {
    double* expected_f = expected_f_.at(row);
    if (!on_frame(row)) {
      expected_f_.clear(row);
      return;
    }
    WindowRows window;
    for (int k = 0; k < kWindowRows; ++k) {
      window.value[k] = value_.at(row + k - kWindowReach);
      window.good[k] = good_.at(row + k - kWindowReach);
    }
    const bool kept = in_band(row);
    Mask* mask = mask_.at(row);
    const bool all_seen = fill_inverse(row, mask);
    const BrdfRow to{kept ? out_.brdf_per_sr.row(row).data() : unused_f_.data(),
                     kept ? out_.u_random_per_sr.row(row).data() : unused_u_.data(), expected_f};
    bool infinite = false;
    for (int c = 0; c < columns_; c += kStrip) infinite = finish_chunk(window, row, c, to) || infinite;
    if (infinite || !all_seen || odd_.at(static_cast<std::size_t>(row) % kWindowRows)) mask_row(mask, to);
    if (!kept) return;
    std::copy_n(mask, columns_, out_.mask.row(row).data());
    if (!out_.expected_per_sr.empty()) std::copy_n(expected_f, columns_, out_.expected_per_sr.row(row).data());
  }

  // Columns that stay in the first-level cache from kernel to kernel.
  bool finish_chunk(const WindowRows& window, int row, int first, const BrdfRow& to) {
    const int n = std::min(kStrip, columns_ - first);
    WindowRows part = window;
    for (int k = 0; k < kWindowRows; ++k) {
      part.value[k] += first;
      part.good[k] += first;
    }
    const CleanRow in{value_.at(row) + first, floor_.at(row) + first, shot_.at(row) + first};
    ask_for_more();
    expected_row(part, in.floor, in.shot, n, expected_.data());
    ask_for_more();
    const bool infinite = brdf_row(in, expected_.data(), inverse_.at(row) + first, n,
                                   {to.brdf_per_sr + first, to.u_random_per_sr + first, to.expected_per_sr + first});
    ask_for_more();
    return infinite;
  }

  // 1/(Ω cos theta_s) of a row. @return whether the detector and the sample see each other all along it: if not, the
  // mask says where.
  bool fill_inverse(int row, Mask* mask) {
    if (geometry_.angles != nullptr) return fill_inverse_from(*geometry_.angles, row, mask);
    const GeometryRow g = geometry_row(geometry_.view, row);
    inverse_projected_row(g, columns_, inverse_.at(row));
    const double last = columns_ - 1;  // both are linear along a row
    if (g.z > 0 && g.z + last * g.z_step > 0 && g.facing > 0 && g.facing + last * g.facing_step > 0) return true;
    for (int c = 0; c < columns_; ++c) {
      const Vector3<double> ray = geometry_.view.pixel(c, row);  // as pixel_angles decides, to the last bit
      if (!(ray.z() > 0)) mask[c] |= kBelowHorizon;
      if (!(geometry_.view.detector_normal.dot(ray) > 0)) mask[c] |= kBehindDetector;
    }
    return false;
  }

  bool fill_inverse_from(const AngleMap& angles, int row, Mask* mask) {
    bool all = true;
    for (int c = 0; c < columns_; ++c) {
      inverse_.at(row)[c] = 1 / (angles.solid_angle_sr(row, c) * std::cos(angles.theta_s_rad(row, c)));
      mask[c] |= angles.mask(row, c);
      all = all && angles.mask(row, c) == 0;
    }
    return all;
  }

  // The rare row with pixels that have a good count and no BRDF.
  void mask_row(Mask* mask, const BrdfRow& to) {
    for (int c = 0; c < columns_; ++c) {
      if (mask[c] == 0 && !std::isfinite(to.brdf_per_sr[c])) mask[c] = kNoData;
      if (mask[c] == 0) continue;
      to.brdf_per_sr[c] = to.expected_per_sr[c] = kNaN;
      to.u_random_per_sr[c] = std::numeric_limits<float>::quiet_NaN();
    }
  }

  void add_pose(int row) {
    float* total = out_.u_total_per_sr.empty() ? nullptr : out_.u_total_per_sr.row(row).data();
    const float* u_random = out_.u_random_per_sr.row(row).data();
    if (geometry_.pose == nullptr) {
      if (total != nullptr) std::copy_n(u_random, columns_, total);
      return;
    }
    float* u = out_.u_pose_per_sr.row(row).data();
    geometry_.pose->squares(tiles_, row, {expected_f_.at(row - 1), expected_f_.at(row), expected_f_.at(row + 1)}, u);
    total == nullptr ? square_roots(columns_, u) : pose_and_total(columns_, u_random, u, total);
  }

  const RowReducer& reducer_;
  const FusedGeometry& geometry_;
  FusedPlanes& out_;
  int rows_, columns_, first_ = 0, last_ = 0;
  int next_row_ = 0, asked_ = 0;  // columns of the next row that are on their way
  RowReducer::Scratch scratch_;
  std::vector<PoseTiles::Tile> tiles_;
  std::array<bool, 3> spills_{};
  std::array<bool, kWindowRows> odd_{};  // pixels of mask 0 without a finite value
  RowRing<Mask, 6> mask_{columns_, 0, Mask{0}};
  RowRing<double, kWindowRows + 1> value_{columns_, kRowMargin, 0.0};
  RowRing<std::uint8_t, kWindowRows + 1> good_{columns_, kRowMargin, std::uint8_t{0}};
  RowRing<float, kWindowRows + 1> floor_{columns_, 0, 0.f}, shot_{columns_, 0, 0.f};
  RowRing<double, 3> expected_f_{columns_, kRowMargin, kNaN};
  alignas(64) std::array<double, kStrip> expected_;
  RowRing<double, 1> inverse_{columns_, 0, 0.0};
  std::vector<double> unused_f_;
  std::vector<float> unused_u_;
};

template <class T>
void shape(Grid<T>& plane, int rows, int columns, bool wanted) {
  if (!wanted) {
    plane = {};
  } else if (plane.rows() != rows || plane.columns() != columns) {
    plane = Grid<T>(rows, columns);
  }
}

}  // namespace

void fused_map(const FusedFrames& frames, const FusedGeometry& geometry, const FusedOptions& options,
               FusedPlanes& out) {
  const RowReducer reducer(frames.frames, frames.dark, frames.sensor, frames.response, frames.exposure_s,
                           frames.factor);
  const int rows = frames.dark.level_dn.rows(), columns = frames.dark.level_dn.columns();
  shape(out.brdf_per_sr, rows, columns, true);
  shape(out.u_random_per_sr, rows, columns, true);
  shape(out.mask, rows, columns, true);
  shape(out.u_pose_per_sr, rows, columns, geometry.pose != nullptr);
  shape(out.u_total_per_sr, rows, columns, options.with_total);
  shape(out.expected_per_sr, rows, columns, options.with_expected);
  const int bands = (rows + kFusedBand - 1) / kFusedBand;
  for_ranges(bands, 1, [&](int first, int last) {
    Band band(reducer, geometry, out);
    for (int index = first; index < last; ++index) band.run(index);
  });
}

std::span<const MethodBound> brdf_bounds() {
  static constexpr const char* kDomain = "finite counts, theta_s < 90 deg";
  static constexpr std::array kBounds{
      MethodBound{"brdf", "fused", "BRDF", "exact chain", kDomain, "relative, over cos theta_s", kFusedBrdfMaxError},
      MethodBound{"brdf", "fused", "u_random", "exact chain", kDomain, "relative", kFusedUncertaintyMaxError},
      MethodBound{"brdf", "fused", "u_pose, u_total", "exact chain", "three calibrated parameters or more", "relative",
                  kFusedPoseMaxError},
      MethodBound{"brdf", "exact", "u_pose", "sum over causes at every pixel", "calibrated instrument",
                  "relative to the largest u_pose", kPoseMaxError},
  };
  return kBounds;
}

}  // namespace scatmap
