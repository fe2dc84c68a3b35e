#include "scatmap/model/tile.h"

#include <algorithm>
#include <cmath>

namespace scatmap {
namespace {

// Normal about which a term's light is brightest in mirror direction.
Vector3<double> brightest_normal(const ModelKernel::Term& term) {
  const auto* lobe = std::get_if<LobeKernel>(&term);
  if (lobe == nullptr || !lobe->constants().tilted) return Vector3<double>::UnitZ();
  return lobe->constants().facet_from_sample.row(2).transpose();
}

double value_at(const ModelKernel& kernel, const DirectionPlane& plane, double column, double row) {
  double value = 0;
  kernel.row(plane, column, row, Amplitudes::kDouble, {&value, 1});
  return value;
}

// The pixel of the array nearest to where the ray along `direction` meets the detector (Cramer's rule).
std::pair<double, double> nearest_pixel(const DirectionPlane& plane, const Vector3<double>& direction, int rows,
                                        int columns) {
  const Vector3<double> across = plane.column_step.cross(plane.row_step);
  const Vector3<double> in_plane = direction * (across.dot(plane.origin) / across.dot(direction)) - plane.origin;
  const double area2 = across.squaredNorm();
  const double column = in_plane.cross(plane.row_step).dot(across) / area2;
  const double row = plane.column_step.cross(in_plane).dot(across) / area2;
  const auto clamped = [](double v, int count) { return v > 0 ? std::min(std::round(v), count - 1.0) : 0.0; };
  return {clamped(column, columns), clamped(row, rows)};
}

}  // namespace

TileTerms all_terms(const ModelKernel& kernel) {
  TileTerms out;
  for (std::size_t i = 0; i < kernel.terms().size(); ++i) out.active.push_back(i);
  out.constant_per_sr = out.floor_per_sr = kernel.constant_per_sr();
  return out;
}

TileTerms narrowed(const TileTerms& terms, const ModelKernel& kernel, const DirectionPlane& plane, const Tile& tile,
                   double margin, const ModelTolerance& tolerance, double share) {
  const auto d = range_directions<0>(plane, kernel.wi(), tile.range(margin), Along::kColumns);
  TileTerms out;
  out.constant_per_sr = terms.constant_per_sr;
  out.spent_per_sr = terms.spent_per_sr;
  out.cos_theta_s = d.ws[2].c[0];
  std::vector<Interval> values;
  double low = terms.constant_per_sr - terms.spent_per_sr;
  for (const std::size_t i : terms.active) {
    values.push_back(term_series(kernel.terms()[i], d).c[0]);
    low += values.back().low;
  }
  out.floor_per_sr = std::max(terms.floor_per_sr, low);
  const double allowed = share * out.allowed_per_sr(tolerance);
  for (std::size_t j = 0; j < values.size(); ++j) {
    const Interval& v = values[j];
    const double left = allowed - out.spent_per_sr;
    if (v.high <= left) {
      out.spent_per_sr += v.high;
    } else if (v.width() / 2 <= left) {
      out.spent_per_sr += v.width() / 2;
      out.constant_per_sr += v.low + v.width() / 2;
    } else {
      out.active.push_back(terms.active[j]);
      out.values.push_back(v);
    }
  }
  return out;
}

template <int N>
Curvature<N> curvature(const TileTerms& terms, const ModelKernel& kernel, const DirectionPlane& plane, const Tile& tile,
                       double margin) {
  const auto columns = range_directions<N>(plane, kernel.wi(), tile.range(margin), Along::kColumns);
  const auto rows = range_directions<N>(plane, kernel.wi(), tile.range(margin), Along::kRows);
  Curvature<N> out;
  for (const std::size_t i : terms.active) {
    const Series<N> along_columns = term_series(kernel.terms()[i], columns);
    const Series<N> along_rows = term_series(kernel.terms()[i], rows);
    for (std::size_t k = 0; k <= N; ++k) {
      out.columns[k] += along_columns.c[k].magnitude();
      out.rows[k] += along_rows.c[k].magnitude();
    }
  }
  return out;
}

template Curvature<4> curvature<4>(const TileTerms&, const ModelKernel&, const DirectionPlane&, const Tile&, double);
template Curvature<8> curvature<8>(const TileTerms&, const ModelKernel&, const DirectionPlane&, const Tile&, double);

double peak_floor(const ModelKernel& kernel, const DirectionPlane& plane, int rows, int columns) {
  double peak = 0;
  const auto see = [&](double column, double row) {
    const double value = value_at(kernel, plane, column, row);
    if (value > peak) peak = value;
  };
  constexpr int kSteps = 8;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j)
      see(std::floor((columns - 1.0) * i / kSteps), std::floor((rows - 1.0) * j / kSteps));
  }
  for (const ModelKernel::Term& term : kernel.terms()) {
    const Vector3<double> n = brightest_normal(term);
    const auto [column, row] = nearest_pixel(plane, 2 * n.dot(kernel.wi()) * n - kernel.wi(), rows, columns);
    see(column, row);
  }
  return peak;
}

}  // namespace scatmap
