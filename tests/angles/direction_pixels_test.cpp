// Many directions to pixels against pixels placed in long double, over benches of the hard regimes; and which
// directions have no pixel. Does not prove that the array is where the instrument file says.
#include "scatmap/angles/direction_pixels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "scatmap/angles/frame_extent.h"
#include "tests/accuracy/regimes.h"

namespace scatmap {
namespace {

struct Batch {
  explicit Batch(std::size_t n) : x(n), y(n), z(n), column(n), row(n) {}
  std::vector<double> x, y, z, column, row;
  void set(std::size_t i, const Vector3<double>& v) {
    x[i] = v.x();
    y[i] = v.y();
    z[i] = v.z();
  }
  void solve(const SampleView& view, int rows, int columns) {
    pixels_of_directions(view, rows, columns, {x, y, z}, {column, row});
  }
};

// Of the direction from the spot to a position, in long double; unit length, rounded to double at the end.
Vector3<double> direction_to(const SampleView& v, double column, double row) {
  long double p[3], length2 = 0;
  for (int k = 0; k < 3; ++k) {
    p[k] = v.origin[k] + static_cast<long double>(column) * v.column_step[k] +
           static_cast<long double>(row) * v.row_step[k];
    length2 += p[k] * p[k];
  }
  const long double length = std::sqrt(length2);
  return {static_cast<double>(p[0] / length), static_cast<double>(p[1] / length), static_cast<double>(p[2] / length)};
}

class InverseRegimes : public testing::TestWithParam<std::size_t> {};

TEST_P(InverseRegimes, PixelToDirectionToPixel) {
  test::RegimeBenches benches(31 + static_cast<unsigned>(GetParam()));
  double worst = 0;
  int solved = 0;
  for (int i = 0; i < 100; ++i) {
    const auto bench = benches.draw(GetParam());
    const int rows = bench.truth.rows, columns = bench.truth.columns;
    SampleView view;
    try {
      view = sample_view(bench.instrument, bench.pose());
    } catch (const std::exception&) {
      continue;  // refused: beam or detector edge-on
    }
    const FrameExtent extent = frame_extent(view, rows, columns);
    if (!(view.detector_normal.dot(view.origin) > 0)) continue;
    Batch batch(201);
    std::vector<PixelPosition> at;
    for (std::size_t k = 0; k < batch.x.size(); ++k) {
      at.push_back({benches.within(0, columns - 1), benches.within(0, rows - 1)});
      batch.set(k, direction_to(view, at.back().column, at.back().row));
    }
    batch.solve(view, rows, columns);
    // The direction's own rounding moves the pixel too: one unit of the last place.
    const double bound_px = kInverseMaxError_rad * extent.spread / extent.pixel_step_rad;
    for (std::size_t k = 0; k < at.size(); ++k) {
      const double error = std::hypot(batch.column[k] - at[k].column, batch.row[k] - at[k].row) / bound_px;
      if (!(error <= worst)) worst = error;
      ++solved;
    }
  }
  std::printf("%-22s %d directions, worst %.3f of the bound\n", test::kRegimes[GetParam()], solved, worst);
  EXPECT_GE(solved, 3000);
  EXPECT_LE(worst, 1);
}

INSTANTIATE_TEST_SUITE_P(Regimes, InverseRegimes, testing::Range<std::size_t>(0, test::kRegimes.size()));

TEST(DirectionPixels, DirectionsWithoutAPixelAreNaN) {
  std::mt19937_64 rng(8);
  const auto bench = test::random_bench(rng, 1);
  const SampleView view = sample_view(bench.instrument, bench.pose());
  Batch batch(11);  // more than a vector, so that the vector loop and its rest are both tried
  for (std::size_t i = 0; i < batch.x.size(); ++i) batch.set(i, view.pixel(static_cast<double>(10 * i), 20));
  batch.set(1, -view.pixel(10, 10));
  batch.set(2, view.column_step);
  batch.set(3, Vector3<double>::Constant(std::nan("")));
  batch.set(4, Vector3<double>::Zero());
  batch.set(10, -view.pixel(10, 10));
  batch.solve(view, bench.truth.rows, bench.truth.columns);
  for (std::size_t i = 0; i < batch.x.size(); ++i) {
    const bool none = (i >= 1 && i <= 4) || i == 10;
    EXPECT_EQ(std::isnan(batch.column[i]), none) << i;
    EXPECT_EQ(std::isnan(batch.row[i]), none) << i;
    if (!none) {
      EXPECT_NEAR(batch.column[i], static_cast<double>(10 * i), 1e-9);
      EXPECT_NEAR(batch.row[i], 20, 1e-9);
    }
  }
}

}  // namespace
}  // namespace scatmap
