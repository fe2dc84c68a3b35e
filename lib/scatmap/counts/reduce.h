#pragma once
#include <memory>
#include <span>
#include <vector>

#include "scatmap/counts/dark.h"
#include "scatmap/counts/row_kernels.h"

namespace scatmap {

/// Net count rate of one exposure: K raw frames averaged, linearised, dark-subtracted, flat-fielded, per second.
/// Variance of the rate at an expected rate E ≥ 0:  frame_floor + E·shot + dark_floor. The variance is kept as this
/// model and not as a number made from the very count it belongs to: that would give dim pixels that fluctuate down a
/// smaller σ than those that fluctuate up, and bias every weighted mean (see expected_signal.h). dark_floor is one
/// error common to everything the same master dark was subtracted from.
struct Counts {
  Grid<double> rate_dn_per_s;
  Grid<float> frame_floor;  ///< (DN/s)²: read noise, dark shot and quantisation of the K frames' mean
  Grid<float> shot;         ///< DN/s: variance of the mean per unit of expected rate
  Grid<float> dark_floor;   ///< (DN/s)²: variance of the master dark
  Grid<Mask> mask;          ///< kSaturated, kBloom, kHot, kBad, kFlatInvalid, kCosmic
  double exposure_s = 0;
  std::size_t saturated_pixels = 0;
  std::size_t rejected_values = 0;  ///< single values rejected as outliers among the frames

  /// Variance of a pixel at some rate, the dark's included; none is less than that of no light.
  double variance(int row, int column, double rate) const {
    return static_cast<double>(frame_floor(row, column)) + static_cast<double>(dark_floor(row, column)) +
           (rate > 0 ? rate : 0) * static_cast<double>(shot(row, column));
  }
};

/// With three frames or more a value this far from the median of the frames is rejected (cosmic hit); with two, the
/// pixel is masked. The noise model allows for laser drift of kFrameDriftAllowance of the level.
inline constexpr double kFrameOutlierSigmas = 6;
inline constexpr double kFrameDriftAllowance = 0.05;

/// Reduces the frames of one exposure. Saturation is decided on raw counts, in any frame; neighbours of saturated
/// pixels get kBloom. Negative net counts stay. Shapes: all rows × columns of the first frame.
/// @throws Error if shapes differ, a frame's own exposure time contradicts `exposure_s`, or there is no frame
Counts reduce(std::span<const Frame> frames, const MasterDark& dark, const SensorModel& sensor,
              const PixelResponse& response, double exposure_s);

/// @throws Error as reduce
void require_reducible(std::span<const Frame> frames, const MasterDark& dark, double exposure_s);

/// The same for parts of rows, for passes that keep no whole frames: all of Counts but kBloom. T: of the rates; float
/// is within 5e-7 of |rate| plus the frames' scatter.
template <class T>
class RowReducer {
 public:
  /// Arguments must outlive this, and be as require_reducible() asks. @param exposure_s rates are net DN over this
  RowReducer(std::span<const Frame> frames, const MasterDark& dark, const SensorModel& sensor,
             const PixelResponse& response, double exposure_s)
      : frames_(frames), dark_(dark), sensor_(sensor), response_(response), exposure_s_(exposure_s) {}

  /// One per thread.
  struct Scratch {
    std::unique_ptr<StripSums<T>> sums = std::make_unique_for_overwrite<StripSums<T>>();
    std::vector<const float*> raw{};
    std::vector<float, HugePageAllocator<float>> buffer{};  ///< a strip of each frame
    std::vector<double> values{};
  };
  struct Found {
    std::size_t rejected;  ///< values, as outliers
    bool saturated;        ///< some pixel may be
  };
  /// Columns [first, last) of a row. @param out of column `first`
  Found columns(int row, int first, int last, const CountsRow<T>& out, Scratch& scratch) const;
  /// Asks for the inputs of some columns, so that they arrive while others are worked on. A few at a time: a processor
  /// waits when too many lines are under way.
  void prefetch(int row, int first, int last) const;

 private:
  std::size_t judge(int row, int column, std::vector<double>& values, const CountsRow<T>& out, int at) const;

  std::span<const Frame> frames_;
  const MasterDark& dark_;
  const SensorModel& sensor_;
  const PixelResponse& response_;
  double exposure_s_;
};

/// Marks kBloom on the neighbours, in the row `onto`, of what spills in the row `from` (the same row or one beside it).
void mark_bloom(std::span<const Mask> from, std::span<Mask> onto);

}  // namespace scatmap
