// Direction → pixel against pixel → direction, and both against OpenCV's and mrcal's pinhole cameras: a flat detector
// seen from the spot is one. Does not prove lens models, which the product does not have.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>

extern "C" {
#include <mrcal/mrcal.h>
}

#include "scatmap/angles/angle_map.h"
#include "tests/support/random_instrument.h"

namespace scatmap {
namespace {

constexpr double kRoundTrip_px = 1e-9;
constexpr double kPinhole_rad = 1e-12;

// The camera at the spot whose image plane is the detector: focal lengths and centre in pixels, rotation from sample
// axes.
struct Pinhole {
  double fx, fy, cx, cy;
  Matrix3<double> camera_from_sample;
};

Pinhole pinhole(const SampleView& v) {
  const double pc = v.column_step.norm(), pr = v.row_step.norm();
  const Vector3<double> x = v.column_step / pc, y = v.row_step / pr, z = x.cross(y);
  const double distance = z.dot(v.origin);  // negative for a mirrored array: x/z and y/z still hold
  Pinhole p{distance / pc, distance / pr, -x.dot(v.origin) / pc, -y.dot(v.origin) / pr, {}};
  p.camera_from_sample.row(0) = x.transpose();
  p.camera_from_sample.row(1) = y.transpose();
  p.camera_from_sample.row(2) = z.transpose();
  return p;
}

TEST(Inverse, PixelToDirectionToPixel) {
  std::mt19937_64 rng(7);
  double worst = 0;
  for (int i = 0; i < 300; ++i) {
    const auto bench = test::random_bench(rng, 1 + i % 8);
    SampleView view;
    try {
      view = sample_view(bench.instrument, bench.pose());
    } catch (const std::exception&) {
      continue;  // beyond grazing: refused
    }
    for (int k = 0; k < 20; ++k) {
      const double column = std::uniform_real_distribution<double>(-50, bench.truth.columns + 50)(rng);
      const double row = std::uniform_real_distribution<double>(-50, bench.truth.rows + 50)(rng);
      const auto back = pixel_of_direction(view, view.pixel(column, row).normalized());
      ASSERT_TRUE(back.has_value());
      worst = std::max({worst, std::abs(back->column - column), std::abs(back->row - row)});
    }
  }
  EXPECT_LE(worst, kRoundTrip_px);
  EXPECT_GT(worst, 0);
}

TEST(Inverse, DirectionsThatMissTheDetectorHaveNoPixel) {
  std::mt19937_64 rng(8);
  const auto bench = test::random_bench(rng, 1);
  const SampleView view = sample_view(bench.instrument, bench.pose());
  EXPECT_FALSE(pixel_of_direction(view, -view.pixel(10, 10)).has_value());
  EXPECT_FALSE(pixel_of_direction(view, view.column_step).has_value());
  EXPECT_FALSE(pixel_of_direction(view, Vector3<double>::Constant(std::nan(""))).has_value());
}

TEST(Inverse, OpencvProjectPoints) {
  std::mt19937_64 rng(9);
  for (int i = 0; i < 20; ++i) {
    auto bench = test::random_bench(rng, 1);
    bench.instrument.flip_columns = bench.instrument.flip_rows = false;
    const SampleView view = sample_view(bench.instrument, bench.pose());
    const Pinhole p = pinhole(view);
    std::vector<cv::Point3d> rays;
    std::vector<std::pair<int, int>> pixels;
    for (int k = 0; k < 50; ++k) {
      pixels.emplace_back(static_cast<int>(rng() % 2000), static_cast<int>(rng() % 2000));
      const Vector3<double> ray =
          p.camera_from_sample * view.pixel(pixels.back().first, pixels.back().second).normalized();
      rays.emplace_back(ray.x(), ray.y(), ray.z());
    }
    const cv::Mat k = (cv::Mat_<double>(3, 3) << p.fx, 0, p.cx, 0, p.fy, p.cy, 0, 0, 1);
    const cv::Mat zero = cv::Mat::zeros(3, 1, CV_64F);
    std::vector<cv::Point2d> projected;
    cv::projectPoints(rays, zero, zero, k, cv::noArray(), projected);
    for (std::size_t j = 0; j < pixels.size(); ++j) {
      EXPECT_LE(std::abs(projected[j].x - pixels[j].first) / p.fx, kPinhole_rad);
      EXPECT_LE(std::abs(projected[j].y - pixels[j].second) / p.fy, kPinhole_rad);
    }
  }
}

TEST(Inverse, MrcalUnproject) {
  std::mt19937_64 rng(10);
  for (int i = 0; i < 20; ++i) {
    auto bench = test::random_bench(rng, 1);
    bench.instrument.flip_columns = bench.instrument.flip_rows = false;
    const SampleView view = sample_view(bench.instrument, bench.pose());
    const Pinhole p = pinhole(view);
    const double intrinsics[4] = {p.fx, p.fy, p.cx, p.cy};
    mrcal_lensmodel_t pinhole_model{};
    pinhole_model.type = MRCAL_LENSMODEL_PINHOLE;
    std::vector<mrcal_point2_t> pixels(50);
    std::vector<mrcal_point3_t> rays(50);
    for (auto& q : pixels) {
      q.x = static_cast<double>(rng() % 3000);
      q.y = static_cast<double>(rng() % 2000);
    }
    ASSERT_TRUE(
        mrcal_unproject(rays.data(), pixels.data(), static_cast<int>(pixels.size()), &pinhole_model, intrinsics));
    for (std::size_t j = 0; j < pixels.size(); ++j) {
      const Vector3<double> ours = p.camera_from_sample * view.pixel(pixels[j].x, pixels[j].y);
      const Vector3<double> theirs(rays[j].x, rays[j].y, rays[j].z);
      EXPECT_LE(angle_between(ours, theirs), kPinhole_rad);
    }
  }
}

}  // namespace
}  // namespace scatmap
