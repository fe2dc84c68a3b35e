#include "scatmap/brdf/pose_uncertainty.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "scatmap/base/parallel.h"
#include "scatmap/brdf/pose_tiles.h"

namespace scatmap {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Copies of rows with a NaN on either side, as GradientRows asks; rows off the frame are NaN.
class PaddedRows {
 public:
  explicit PaddedRows(const Grid<double>& f) : f_(f), width_(static_cast<std::size_t>(f.columns()) + 2) {
    for (auto& r : rows_) r.assign(width_, kNaN);
  }
  /// Rows are asked for in ascending order.
  GradientRows around(int row) {
    while (filled_ < row + 1) fill(++filled_);
    return {at(row - 1), at(row), at(row + 1)};
  }
  void start(int row) {
    filled_ = row - 2;
    while (filled_ < row) fill(++filled_);
  }

 private:
  std::vector<double>& slot(int row) { return rows_[static_cast<std::size_t>(row + 3) % 3]; }
  const double* at(int row) { return slot(row).data() + 1; }
  void fill(int row) {
    std::vector<double>& to = slot(row);
    if (row < 0 || row >= f_.rows()) {
      std::fill(to.begin(), to.end(), kNaN);
    } else {
      std::copy(f_.row(row).begin(), f_.row(row).end(), to.begin() + 1);
    }
  }

  const Grid<double>& f_;
  std::size_t width_;
  std::vector<double> rows_[3];
  int filled_ = 0;
};

}  // namespace

struct PoseSensitivities::Parts {
  SampleView view;
  ChangeRows changes;
  const Grid<double>& expected;
};

PoseSensitivities::PoseSensitivities(const Instrument& instrument, const Pose& pose,
                                     const Grid<double>& expected_per_sr)
    : parts_(std::make_unique<Parts>(
          Parts{sample_view(instrument, pose), ChangeRows(calibration_changes(instrument, pose)), expected_per_sr})) {}

PoseSensitivities::~PoseSensitivities() = default;

std::size_t PoseSensitivities::count() const { return parts_->changes.size(); }

void PoseSensitivities::at(int row, int column, std::span<double> out) const {
  const Grid<double>& f = parts_->expected;
  double near[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int r = row + i - 1, c = column + j - 1;
      near[i][j] = r < 0 || c < 0 || r >= f.rows() || c >= f.columns() ? kNaN : f(r, c);
    }
  }
  const Gradient g = gradient_at({near[0] + 1, near[1] + 1, near[2] + 1}, 0);
  PoseActions actions(out.size());
  pose_actions(parts_->view, parts_->changes, row, column, actions);
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = g.f * actions.relative[k] + g.per_column * actions.columns[k] + g.per_row * actions.rows[k];
}

std::optional<Grid<float>> pose_uncertainty(const Instrument& instrument, const Pose& pose,
                                            const Grid<double>& expected_per_sr) {
  if (!instrument.calibration || instrument.calibration->parameters.empty()) return std::nullopt;
  const int rows = expected_per_sr.rows(), columns = expected_per_sr.columns();
  const PoseTiles tiles(sample_view(instrument, pose), calibration_changes(instrument, pose), rows, columns);
  Grid<float> out(rows, columns);
  for_each_index((rows + kPoseTile - 1) / kPoseTile, 1, [&](int index) {
    const std::vector<PoseTiles::Tile> band = tiles.band(index);
    const int first = index * kPoseTile, last = std::min(rows, first + kPoseTile);
    PaddedRows padded(expected_per_sr);
    padded.start(first);
    for (int row = first; row < last; ++row) tiles.fill_row(band, row, padded.around(row), {out.row(row).data()});
  });
  return out;
}

}  // namespace scatmap
