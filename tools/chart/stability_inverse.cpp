#include <cmath>

#include "scatmap/angles/angle_map.h"
#include "scatmap/angles/direction_pixels.h"
#include "scatmap/angles/frame_extent.h"
#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "tools/chart/angle_regimes.h"
#include "tools/chart/scene.h"
#include "tools/chart/stability.h"
#include "tools/chart/stability_large.h"

namespace scatmap::tools {
namespace {

// True directions of the pixels that have one, and the pixels they come from.
struct Directions {
  std::vector<double> x, y, z;
  std::vector<PixelPosition> from;
};

Directions directions_of(const AngleSetup& s) {
  const synth::TruthGeometry truth = truth_of(s);
  Directions out;
  for (int row = 0; row < s.bench.rows; ++row) {
    for (int column = 0; column < s.bench.columns; ++column) {
      const auto pixel = truth.pixel(column, row);
      if (!pixel) continue;
      out.x.push_back(static_cast<double>(pixel->direction.x));
      out.y.push_back(static_cast<double>(pixel->direction.y));
      out.z.push_back(static_cast<double>(pixel->direction.z));
      out.from.push_back({static_cast<double>(column), static_cast<double>(row)});
    }
  }
  return out;
}

std::vector<PixelPosition> one_by_one(const SampleView& view, const Directions& d) {
  std::vector<PixelPosition> out;
  for (std::size_t i = 0; i < d.x.size(); ++i)
    out.push_back(pixel_of_direction(view, {d.x[i], d.y[i], d.z[i]}).value_or(PixelPosition{NAN, NAN}));
  return out;
}

std::vector<PixelPosition> in_vectors(const SampleView& view, const synth::Bench& b, const Directions& d) {
  std::vector<double> column(d.x.size()), row(d.x.size());
  pixels_of_directions(view, b.rows, b.columns, {d.x, d.y, d.z}, {column, row});
  std::vector<PixelPosition> out;
  for (std::size_t i = 0; i < column.size(); ++i) out.push_back({column[i], row[i]});
  return out;
}

double worst(const std::vector<PixelPosition>& found, const std::vector<PixelPosition>& from) {
  double out = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double error = std::hypot(found[i].column - from[i].column, found[i].row - from[i].row);
    if (!(error <= out)) out = error;
  }
  return out;
}

void judge(const AngleSetup& s, bool vectors, StabilityCell& cell) {
  const Pose pose{s.stage_deg * kRadPerDeg, s.arm_deg * kRadPerDeg};
  const SampleView view = sample_view(instrument_of(s.bench), pose);
  const Directions d = directions_of(s);
  if (d.from.empty()) {
    cell.verdict = Verdict::kRefuses;
    cell.reason = "no pixel sees the sample";
    return;
  }
  const FrameExtent extent = frame_extent(view, s.bench.rows, s.bench.columns);
  constexpr double kLeastIncidence_rad =
      1e-3;  // as for the angles: at normal incidence the sample's x has no direction
  const double view_rad = kAngleMaxError_rad / std::max(std::sin(incidence_angle(view)), kLeastIncidence_rad);
  cell.bound = (kInverseMaxError_rad + view_rad) * extent.spread / extent.pixel_step_rad;
  cell.worst_error = worst(vectors ? in_vectors(view, s.bench, d) : one_by_one(view, d), d.from);
  if (cell.worst_error <= cell.bound) cell.verdict = Verdict::kHolds;
}

}  // namespace

std::vector<StabilityCell> stability_inverse() {
  std::vector<StabilityCell> out;
  for (const AngleRegime& regime : angle_regimes()) {
    for (const bool vectors : {true, false}) {
      StabilityCell cell;
      cell.job = "inverse";
      cell.regime = regime.name;
      cell.method = vectors ? "vector" : "one by one";
      cell.unit = "px";
      try {
        judge(regime.setup, vectors, cell);
      } catch (const Error& e) {
        cell.verdict = is_impossible(regime.setup) ? Verdict::kRefuses : Verdict::kFails;
        cell.reason = e.what();
      }
      out.push_back(cell);
    }
  }
  for (const StabilityCell& cell : large_inverse()) out.push_back(cell);
  return out;
}

}  // namespace scatmap::tools
