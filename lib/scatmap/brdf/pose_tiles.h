#pragma once
#include <span>
#include <vector>

#include "scatmap/angles/view_change.h"

namespace scatmap {

inline constexpr int kPoseTile = 128;
inline constexpr double kPoseMaxError = 1e-3;

/// Three rows of a smooth estimate of f: the one in hand and its neighbours, NaN where masked. Every pointer is to
/// the first column that is asked for; one more on either side is readable, and what is off the frame is NaN.
struct GradientRows {
  const double* above;
  const double* here;
  const double* below;
};

struct Gradient {
  double f, per_column, per_row;
};

/// f and its slopes per pixel at an index: central differences, one-sided beside a NaN, 0 without neighbours.
Gradient gradient_at(const GradientRows& rows, int index);

/// A row of uncertainties, from the same column on.
struct PoseRow {
  float* u_pose;
  const float* u_random = nullptr;
  float* u_total = nullptr;  ///< sqrt(u_random² + u_pose²); nullptr: not wanted
};

/// The changes of the geometry with each number in a row of its own, as vector loops want them.
class ChangeRows {
 public:
  static constexpr std::size_t kNumbers = 16;  ///< origin, column_step, row_step, normal, to_source, ln_area
  explicit ChangeRows(const std::vector<ViewChange>& changes);
  std::size_t size() const { return size_; }
  const double* row(std::size_t number) const { return data_.data() + number * size_; }

 private:
  std::size_t size_;
  std::vector<double> data_;
};

/// How each change acts on a pixel: f changes by f·relative + per_column·columns + per_row·rows.
struct PoseActions {
  explicit PoseActions(std::size_t changes) : relative(changes), columns(changes), rows(changes) {}
  std::vector<double> relative, columns, rows;
};

/// Fills `actions` for a pixel position.
void pose_actions(const SampleView& view, const ChangeRows& changes, double row, double column, PoseActions& actions);

/// u_pose row by row (pose_uncertainty.h). The norm over all changes is a quadratic form in (f, per_column, per_row)
/// whose six coefficients vary smoothly over the detector: exact at nine points of a tile, biquadratic in between,
/// error below kPoseMaxError. Where 1/cos theta_s or the distance change too fast for that, pixels are exact.
class PoseTiles {
 public:
  /// @param changes not empty
  PoseTiles(const SampleView& view, const std::vector<ViewChange>& changes, int rows, int columns);

  struct Tile {
    int first_column, last_column;  ///< last: one past
    bool exact;                     ///< no form: pixel by pixel
    /// a + t (b + t c) down the tile, t from 0 to 1, for its left, middle and right column; coefficients of f·f,
    /// f·column, f·row, column·column, column·row, row·row, then padding
    alignas(64) double a[3][8], b[3][8], c[3][8];
  };
  /// The tiles of rows [index·kPoseTile, (index + 1)·kPoseTile).
  std::vector<Tile> band(int index) const;

  /// u_pose along a row of some neighbouring tiles of a band; NaN where f is.
  void fill_row(std::span<const Tile> tiles, int row, const GradientRows& f, const PoseRow& out) const;

 private:
  void fill_form(Tile& tile, int first_row, int last_row) const;
  double exact_square(int row, int column, const Gradient& g) const;

  SampleView view_;
  ChangeRows changes_;
  int rows_, columns_;
};

}  // namespace scatmap
