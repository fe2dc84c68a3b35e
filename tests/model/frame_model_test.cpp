// The methods over a frame: horizon and NaN as PreparedModel has them, the same bytes at any number of threads, culling
// leaves out and interpolates what it may, means over pixels against long double quadrature, choice by tolerance.
// Not proven: the methods' bounds (accuracy/model_test.cpp), nor that a mean is right where pixel_average.h says that
// its criterion is tested only and no test here looks.
#include "scatmap/model/frame_model.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "accuracy/model_regimes.h"
#include "model/scene.h"

namespace scatmap {
namespace {

using accuracy::ModelCase;
using Long = long double;

constexpr int kRows = 150, kColumns = 333;
constexpr ModelMethod kMethods[] = {ModelMethod::kExact, ModelMethod::kVector, ModelMethod::kSingle,
                                    ModelMethod::kCulled};

// A detector of the paper's size around the specular direction with few, large pixels.
DirectionPlane plane_at(double theta_i_deg, double pixel_m) {
  const double t = theta_i_deg * kRadPerDeg;
  DirectionPlane p;
  p.column_step = pixel_m * Vector3<double>(std::cos(t), 0, -std::sin(t));
  p.row_step = {0, pixel_m, 0};
  p.origin = test::kDistance_m * Vector3<double>(std::sin(t), 0, std::cos(t)) - kColumns / 2 * p.column_step -
             kRows / 2 * p.row_step;
  return p;
}

std::vector<double> filled(const Model& model, const Vector3<double>& wi, const DirectionPlane& plane,
                           const FrameModelOptions& options) {
  std::vector<double> out(static_cast<std::size_t>(kRows) * kColumns);
  FrameModel(model, wi, test::kDistance_m, plane, kRows, kColumns, options).fill(out);
  return out;
}

Model many_terms() {
  Model m = test::paper_model(12);
  m.terms.push_back(LambertianTerm{0.05});
  m.terms.push_back(LambertianTerm{0.01});
  m.terms.push_back(MicrofacetTerm{0.2, 0.2, {0.06, 4.3}, 0, 0});
  m.terms.push_back(StripesTerm{20, 3e-4, 2e-5, 2e-3, StripesForm::kGrating});
  return m;
}

TEST(FrameModel, GivesTheSameBytesAtAnyNumberOfThreads) {
  for (const ModelMethod method : kMethods) {
    for (const bool average : {false, method == ModelMethod::kCulled}) {
      std::vector<std::vector<double>> results;
      for (const std::size_t threads : {1U, 2U, 5U}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        results.push_back(filled(many_terms(), test::source_deg(20), plane_at(20, 4e-5), {method, 1e-5, average}));
      }
      for (const auto& r : results) {
        EXPECT_EQ(std::memcmp(r.data(), results[0].data(), r.size() * sizeof(double)), 0) << model_method_name(method);
      }
      EXPECT_GT(results[0][0], 0);
    }
  }
}

// Pixels of a frame that the horizon crosses, and of one that it does not.
TEST(FrameModel, IsNanExactlyWherePreparedModelIs) {
  for (const double theta_i_deg : {20.0, 89.0}) {
    DirectionPlane plane = plane_at(theta_i_deg, 1e-4);
    const PreparedModel exact(many_terms(), test::source_deg(theta_i_deg), test::kDistance_m);
    for (const ModelMethod method : kMethods) {
      for (const bool average : {false, method == ModelMethod::kCulled}) {
        const auto values = filled(many_terms(), test::source_deg(theta_i_deg), plane, {method, 1e-2, average});
        int nan = 0;
        for (int r = 0; r < kRows; ++r) {
          for (int c = 0; c < kColumns; ++c) {
            const bool is_nan = std::isnan(values[static_cast<std::size_t>(r * kColumns + c)]);
            EXPECT_EQ(is_nan, std::isnan(exact(plane.at(c, r).normalized()))) << c << " " << r;
            nan += is_nan ? 1 : 0;
          }
        }
        EXPECT_EQ(nan > 0, theta_i_deg == 89.0) << model_method_name(method);
      }
    }
  }
}

TEST(FrameModel, IsNanForASourceBelowTheHorizon) {
  for (const ModelMethod method : kMethods) {
    for (const bool average : {false, method == ModelMethod::kCulled}) {
      for (const double v : filled(many_terms(), {-1, 0, -0.1}, plane_at(20, 4e-5), {method, 1e-3, average}))
        ASSERT_TRUE(std::isnan(v));
    }
  }
}

TEST(ModelKernel, TakesAnyDirectionsNanIncluded) {
  const ModelKernel kernel(many_terms(), test::source_deg(20), test::kDistance_m);
  const PreparedModel exact(many_terms(), test::source_deg(20), test::kDistance_m);
  std::vector<Vector3<double>> ws;
  for (int i = 0; i < 131; ++i) ws.push_back(test::sensor_direction(20, 1e-4 * (i - 60), 3e-5 * i));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ws[3].x() = nan;
  ws[70].y() = nan;
  ws[130].z() = nan;
  ws[5] = {1, 0, 0};
  std::vector<double> values(ws.size());
  kernel.directions(ws, Amplitudes::kDouble, values);
  for (std::size_t i = 0; i < ws.size(); ++i) {
    const double expected = exact(ws[i]);
    ASSERT_EQ(std::isnan(values[i]), std::isnan(expected)) << i;
    if (!std::isnan(expected)) {
      EXPECT_NEAR(values[i], expected, 1e-9 * expected);
    }
  }
}

TEST(Culling, LeavesOutWhatCannotMatterAndKeepsWhatDoes) {
  const Model model = test::paper_model();
  const ModelKernel kernel(model, test::source_deg(20), test::kDistance_m);
  const DirectionPlane plane = plane_at(20, 4e-5);
  const ModelTolerance tolerance{1e-6, 1e4};
  const auto active = [&](const Tile& tile) {
    return narrowed(all_terms(kernel), kernel, plane, tile, 0, tolerance, 0.4).active;
  };
  EXPECT_EQ(active({0, 0, 64, 16}), std::vector<std::size_t>{});
  EXPECT_EQ(active({kColumns / 2 - 4, kRows / 2 - 4, 8, 8}), (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(active({kColumns / 2 - 4, kRows / 2 + 50, 8, 8}), (std::vector<std::size_t>{2}));
}

// Composite eight-point Simpson-like midpoints would share nothing with the product's Gauss points: plain midpoints in
// long double, Richardson-extrapolated once.
Long mean_over_pixel(const ModelCase& c, const DirectionPlane& plane, int column, int row) {
  const auto midpoints = [&](int n) {
    Long sum = 0;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const Long x = column + (j + 0.5L) / n - 0.5L, y = row + (i + 0.5L) / n - 0.5L;
        const Vector3<Long> ray =
            plane.origin.cast<Long>() + x * plane.column_step.cast<Long>() + y * plane.row_step.cast<Long>();
        sum += accuracy::truth_at(c, ray / ray.norm());
      }
    }
    return sum / (Long(n) * n);
  };
  return (4 * midpoints(120) - midpoints(60)) / 3;
}

// The paper's terms on pixels from a tenth of a lobe's width to twice it: centre and mean differ by up to a factor.
TEST(PixelAverage, AgreesWithLongDoubleQuadrature) {
  std::mt19937_64 random(5);
  double largest_change = 0;
  for (const double pixel_m : {1.3e-5, 5e-5, 2e-4}) {
    ModelCase c = accuracy::empty_case(test::source_deg(20), 7);
    accuracy::add_lobe(c, 0.015, 2e-4, {3.6, 0});
    accuracy::add_lobe(c, 0.7, 2e-4, {1.4, 0}, 0.2, 45);
    accuracy::add_stripes(c, 300, 800, 10, 40, StripesForm::kPaper);
    accuracy::add_lambertian(c, 1e-3);
    const DirectionPlane plane = plane_at(20, pixel_m);
    constexpr double kTolerance = 1e-6;
    const auto points = filled(c.model, c.wi, plane, {ModelMethod::kVector});
    const auto means = filled(c.model, c.wi, plane, {ModelMethod::kCulled, kTolerance, true});
    double peak = 0;
    for (const double v : points) peak = std::max(peak, v);
    for (int k = 0; k < 25; ++k) {
      // Near the specular pixel and on the fringes, where means differ most.
      const int column = kColumns / 2 + std::uniform_int_distribution<int>(-6, 6)(random);
      const int row = kRows / 2 + std::uniform_int_distribution<int>(-40, 40)(random);
      const auto i = static_cast<std::size_t>(row * kColumns + column);
      const auto expected = static_cast<double>(mean_over_pixel(c, plane, column, row));
      const double scale = std::max(expected, kPeakShare * peak);
      EXPECT_LE(std::abs(means[i] - expected) / scale, kTolerance + 1e-8) << column << " " << row << " " << pixel_m;
      largest_change = std::max(largest_change, std::abs(points[i] / expected - 1));
    }
  }
  EXPECT_GT(largest_change, 0.5);
}

// Every pixel of the frame, also those that no term reaches: with pixels this small, means and points hardly differ.
TEST(PixelAverage, OfSmallPixelsIsTheValueAtTheirCentres) {
  const auto points = filled(many_terms(), test::source_deg(20), plane_at(20, 1e-6), {ModelMethod::kVector});
  const auto means = filled(many_terms(), test::source_deg(20), plane_at(20, 1e-6), {ModelMethod::kCulled, 1e-5, true});
  for (std::size_t i = 0; i < points.size(); ++i) ASSERT_NEAR(means[i], points[i], 2e-2 * points[i]) << i;
}

// Light is conserved: a lobe far narrower than a pixel, whose centre value is anything, has the integral of the lobe
// on fine pixels.
TEST(PixelAverage, KeepsTheSumOfALobeNarrowerThanAPixel) {
  ModelCase c = accuracy::empty_case(test::source_deg(30));
  accuracy::add_lobe(c, 1, 2e-5, {1.5, 0});
  DirectionPlane coarse = plane_at(30, 1e-4);
  DirectionPlane fine = plane_at(30, 1e-6);
  fine.origin += 0.37 * coarse.column_step;  // the peak stands off the coarse pixels' centres
  coarse.origin += 0.37 * coarse.column_step;
  double coarse_sum = 0, fine_sum = 0;
  for (const double v : filled(c.model, c.wi, coarse, {ModelMethod::kCulled, 1e-8, true})) coarse_sum += v * 1e-8;
  for (const double v : filled(c.model, c.wi, fine, {ModelMethod::kVector})) fine_sum += v * 1e-12;
  EXPECT_NEAR(coarse_sum / fine_sum, 1, 1e-6);
}

TEST(ModelMethods, TheCheapestWithinTheToleranceIsChosen) {
  EXPECT_EQ(choose_model_method(1e-3), ModelMethod::kCulled);
  EXPECT_EQ(choose_model_method(kDefaultModelTolerance), ModelMethod::kCulled);
  EXPECT_EQ(choose_model_method(5e-12), ModelMethod::kVector);
  EXPECT_EQ(choose_model_method(1e-15), ModelMethod::kExact);
  for (const ModelMethod method : kMethods) EXPECT_EQ(model_method_of(model_method_name(method)), method);
  EXPECT_FALSE(model_method_of("fastest").has_value());
}

}  // namespace
}  // namespace scatmap
