#include "scatmap/brdf/fused.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include "scatmap/base/parallel.h"
#include "scatmap/base/stream_copy.h"
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

template <class T>
std::size_t bytes(const FusedPlanes<T>& p) {
  const auto of = [](const auto& plane) { return plane.size() * sizeof(*plane.data()); };
  return of(p.brdf_per_sr) + of(p.u_random_per_sr) + of(p.u_pose_per_sr) + of(p.u_total_per_sr) + of(p.mask) +
         of(p.expected_per_sr);
}

// One band of rows, streamed: row r is reduced; r − 1 then knows its blooming neighbours; r − 3 its window; r − 4 its
// gradient.
template <class T>
class Band {
 public:
  Band(const RowReducer<float>& reducer, const FusedGeometry& geometry, double per_dn, FusedPlanes<T>& out)
      : reducer_(reducer),
        geometry_(geometry),
        per_dn_(per_dn),
        out_(out),
        rows_(out.mask.rows()),
        columns_(out.mask.columns()),
        streamed_(bytes(out) >= kStreamedBytes / 4) {}  // the inputs are as large again

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
    finish_streams();
  }

 private:
  bool on_frame(int row) const { return row >= 0 && row < rows_; }
  CleanRow at(int row) { return {value_.at(row), floor_.at(row), shot_.at(row)}; }
  bool in_band(int row) const { return row >= first_ && row < last_; }

  // Some more of the next row's inputs are on their way while this one is worked on.
  void ask_for_more() {
    if (asked_ >= columns_) return;
    constexpr int kSome = 80;
    reducer_.prefetch(next_row_, asked_, asked_ + kSome);
    asked_ += kSome;
  }

  void reduce_row(int row) {
    if (!on_frame(row)) {
      mask_.clear(row);
      return;
    }
    const CountsRow<float> to{value_.at(row), floor_.at(row), shot_.at(row), nullptr, mask_.at(row)};
    spills_.at(static_cast<std::size_t>(row + 3) % 3) =
        reducer_.columns(row, 0, columns_, to, scratch_).saturated &&
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
    if (!on_frame(row)) {
      expected_.clear(row);
      return;
    }
    WindowRows window;
    for (int k = 0; k < kWindowRows; ++k) {
      window.value[k] = value_.at(row + k - kWindowReach);
      window.good[k] = good_.at(row + k - kWindowReach);
    }
    const bool odd = !all_seen(row, mask_.at(row)) || odd_.at(static_cast<std::size_t>(row) % kWindowRows);
    for (int c = 0; c < columns_; c += kStrip) finish_strip(window, row, c, odd);
  }

  // Columns that stay in the first-level cache from kernel to kernel.
  void finish_strip(const WindowRows& window, int row, int first, bool odd) {
    const int n = std::min(kStrip, columns_ - first);
    WindowRows part = window;
    for (int k = 0; k < kWindowRows; ++k) {
      part.value[k] += first;
      part.good[k] += first;
    }
    fill_per_dn(row, first, n);
    ask_for_more();
    const bool kept = in_band(row), direct = kept && !streamed_;
    BrdfStrip to{brdf_.data(), u_random_.at(row) + first, expected_.at(row) + first};
    if constexpr (std::is_same_v<T, float>) {
      if (direct) to.brdf_per_sr = out_.brdf_per_sr.row(row).data() + first;
    }
    if (direct) to.u_random_per_sr = out_.u_random_per_sr.row(row).data() + first;
    const bool infinite = map_strip(part, floor_.at(row) + first, shot_.at(row) + first, per_dn_of_.data(), n, to);
    ask_for_more();
    Mask* mask = mask_.at(row) + first;
    if (infinite || odd) mask_strip(mask, n, to);
    if (!kept) return;
    if (to.brdf_per_sr == brdf_.data()) send(to.brdf_per_sr, n, out_.brdf_per_sr, row, first);
    if (streamed_) send(to.u_random_per_sr, n, out_.u_random_per_sr, row, first);
    send(mask, n, out_.mask, row, first);
    if (!out_.expected_per_sr.empty()) send(to.expected_per_sr, n, out_.expected_per_sr, row, first);
  }

  // Whether the detector and the sample see each other all along a row: if not, the mask says where.
  bool all_seen(int row, Mask* mask) {
    if (geometry_.angles != nullptr) {
      Mask any = 0;
      for (int c = 0; c < columns_; ++c) {
        mask[c] |= geometry_.angles->mask(row, c);
        any |= geometry_.angles->mask(row, c);
      }
      return any == 0;
    }
    along_row_ = geometry_row(geometry_.view, row);
    const GeometryRow& g = along_row_;
    const double last = columns_ - 1;  // both are linear along a row
    if (g.z > 0 && g.z + last * g.z_step > 0 && g.facing > 0 && g.facing + last * g.facing_step > 0) return true;
    for (int c = 0; c < columns_; ++c) {
      const Vector3<double> ray = geometry_.view.pixel(c, row);  // as pixel_angles decides, to the last bit
      if (!(ray.z() > 0)) mask[c] |= kBelowHorizon;
      if (!(geometry_.view.detector_normal.dot(ray) > 0)) mask[c] |= kBehindDetector;
    }
    return false;
  }

  // Map units per DN along a strip.
  void fill_per_dn(int row, int first, int n) {
    if (geometry_.angles == nullptr) return inverse_projected(along_row_, per_dn_, first, n, per_dn_of_.data());
    const AngleMap& angles = *geometry_.angles;
    for (int i = 0; i < n; ++i) {
      per_dn_of_[static_cast<std::size_t>(i)] =
          per_dn_ / (angles.solid_angle_sr(row, first + i) * std::cos(angles.theta_s_rad(row, first + i)));
    }
  }

  // The rare strip with pixels that have a good count and no BRDF.
  static void mask_strip(Mask* mask, int n, const BrdfStrip& to) {
    for (int i = 0; i < n; ++i) {
      if (mask[i] == 0 && !std::isfinite(to.brdf_per_sr[i])) mask[i] = kNoData;
      if (mask[i] == 0) continue;
      to.brdf_per_sr[i] = to.u_random_per_sr[i] = std::numeric_limits<float>::quiet_NaN();
      to.expected_per_sr[i] = kNaN;
    }
  }

  void add_pose(int row) {
    const float* u_random = streamed_ ? u_random_.at(row) : out_.u_random_per_sr.row(row).data();
    const bool with_total = !out_.u_total_per_sr.empty();
    if (geometry_.pose == nullptr) {
      if (with_total) send(u_random, columns_, out_.u_total_per_sr, row, 0);
      return;
    }
    float* u = streamed_ ? u_pose_.at(row) : out_.u_pose_per_sr.row(row).data();
    float* total = streamed_ ? u_total_.at(row) : with_total ? out_.u_total_per_sr.row(row).data() : nullptr;
    geometry_.pose->fill_row(tiles_, row, {expected_.at(row - 1), expected_.at(row), expected_.at(row + 1)},
                             {u, u_random, with_total ? total : nullptr});
    if (!streamed_) return;
    send(u, columns_, out_.u_pose_per_sr, row, 0);
    if (with_total) send(total, columns_, out_.u_total_per_sr, row, 0);
  }

  template <class From, class To>
  void send(const From* from, int count, Grid<To>& plane, int row, int first) const {
    To* to = plane.row(row).data() + first;
    if constexpr (std::is_same_v<From, To>) {
      streamed_ ? stream_copy(from, static_cast<std::size_t>(count), to) : void(std::copy_n(from, count, to));
    } else {
      std::copy_n(from, count, to);
    }
  }

  const RowReducer<float>& reducer_;
  const FusedGeometry& geometry_;
  double per_dn_;
  FusedPlanes<T>& out_;
  int rows_, columns_, first_ = 0, last_ = 0;
  bool streamed_;
  int next_row_ = 0, asked_ = 0;  // columns of the next row that are on their way
  RowReducer<float>::Scratch scratch_;
  std::vector<PoseTiles::Tile> tiles_;
  std::array<bool, 3> spills_{};
  std::array<bool, kWindowRows> odd_{};  // pixels of mask 0 without a finite value
  RowRing<Mask, 6> mask_{columns_, 0, Mask{0}};
  RowRing<float, kWindowRows + 1> value_{columns_, kRowMargin, 0.f};
  RowRing<std::uint8_t, kWindowRows + 1> good_{columns_, kRowMargin, std::uint8_t{0}};
  RowRing<float, kWindowRows + 1> floor_{columns_, 0, 0.f}, shot_{columns_, 0, 0.f};
  RowRing<double, 3> expected_{columns_, kRowMargin, kNaN};
  RowRing<float, 2> u_random_{columns_, 0, 0.f};
  RowRing<float, 1> u_pose_{columns_, 0, 0.f}, u_total_{columns_, 0, 0.f};
  GeometryRow along_row_{};
  alignas(64) std::array<double, kStrip> per_dn_of_;
  alignas(64) std::array<float, kStrip> brdf_;
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

template <class T>
void fused_map(const FusedFrames& frames, const FusedGeometry& geometry, const FusedOptions& options,
               FusedPlanes<T>& out) {
  require_reducible(frames.frames, frames.dark, frames.exposure_s);
  // Counts stay in DN, where float has room on either side, until they are divided by the geometry.
  const RowReducer<float> reducer(frames.frames, frames.dark, frames.sensor, frames.response, 1);
  const double per_dn = frames.factor / frames.exposure_s;
  const int rows = frames.dark.level_dn.rows(), columns = frames.dark.level_dn.columns();
  shape(out.brdf_per_sr, rows, columns, true);
  shape(out.u_random_per_sr, rows, columns, true);
  shape(out.mask, rows, columns, true);
  shape(out.u_pose_per_sr, rows, columns, geometry.pose != nullptr);
  shape(out.u_total_per_sr, rows, columns, options.with_total);
  shape(out.expected_per_sr, rows, columns, options.with_expected);
  const int bands = (rows + kFusedBand - 1) / kFusedBand;
  for_ranges(bands, 1, [&](int first, int last) {
    Band<T> band(reducer, geometry, per_dn, out);
    for (int index = first; index < last; ++index) band.run(index);
  });
}

template void fused_map(const FusedFrames&, const FusedGeometry&, const FusedOptions&, FusedPlanes<float>&);
template void fused_map(const FusedFrames&, const FusedGeometry&, const FusedOptions&, FusedPlanes<double>&);

std::span<const MethodBound> brdf_bounds() {
  static constexpr const char* kDomain = "finite counts, theta_s < 90 deg";
  static constexpr std::array kBounds{
      MethodBound{"brdf", "fused", "BRDF", "exact chain", kDomain, "of its size and sqrt(frames) u_random",
                  kFusedBrdfMaxError},
      MethodBound{"brdf", "fused", "u_random", "exact chain", kDomain, "relative", kFusedUncertaintyMaxError},
      MethodBound{"brdf", "fused", "u_pose, u_total", "exact chain", "three calibrated parameters or more",
                  "relative to u_total", kFusedPoseMaxError},
      MethodBound{"brdf", "exact", "u_pose", "sum over causes at every pixel", "calibrated instrument",
                  "relative to the largest u_pose", kPoseMaxError},
  };
  return kBounds;
}

}  // namespace scatmap
