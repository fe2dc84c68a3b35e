// Rays of mrcal's lens models, read through the optional module, against forward projections written here from the
// models' published definitions; the pinhole against its closed form. Does not prove mrcal's splined models, nor the
// bare CCD's equality with a pinhole (tests/calib/export_cameramodel_test.cpp).
#include "scatmap/angles/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/output_file.h"

namespace scatmap {
namespace {

constexpr int kColumns = 60, kRows = 40;

std::filesystem::path model_file(const std::string& name, const std::vector<double>& intrinsics) {
  std::string list;
  for (const double v : intrinsics) list += (list.empty() ? "" : ", ") + number_text(v);
  const std::filesystem::path path = testing::TempDir() + "lens_test.cameramodel";
  write_text_file(path,
                  "{ 'lensmodel': '" + name + "', 'extrinsics': [ 0, 0, 0, 0, 0, 0 ], 'intrinsics': [ " + list +
                      " ], 'imagersize': [ " + std::to_string(kColumns) + ", " + std::to_string(kRows) + " ] }\n",
                  Overwrite::kForce);
  return path;
}

using Projection = std::function<PixelPosition(const Vector3<double>&)>;

// Largest distance of a pixel from the projection of its own ray.
double round_trip_px(const LensRays& rays, const Projection& project) {
  double worst = 0;
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const PixelPosition p = project(rays.direction(r, c));
      const double error = std::hypot(p.column - c, p.row - r);
      worst = error <= worst ? worst : error;  // NaN stays
    }
  }
  return worst;
}

TEST(Lens, PinholeIsItsClosedForm) {
  const double fx = 800.25, fy = 790.5, cx = 31.7, cy = 18.2;
  const LensRays rays = load_lens_rays(model_file("LENSMODEL_PINHOLE", {fx, fy, cx, cy}), kColumns, kRows);
  EXPECT_EQ(rays.model, "LENSMODEL_PINHOLE");
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const Vector3<double> ray((c - cx) / fx, (r - cy) / fy, 1);
      EXPECT_LE(angle_between<double>(rays.direction(r, c), ray), 1e-15);
      const double solid_angle = 1 / (fx * fy * std::pow(ray.norm(), 3));
      EXPECT_LE(std::abs(rays.solid_angle_sr(r, c) / solid_angle - 1), 2e-6);  // differences over one pixel: (1/f)²
    }
  }
}

TEST(Lens, Opencv8InvertsItsForwardModel) {
  const std::vector<double> p{90, 92, 29.3, 20.1, -0.25, 0.06, 1e-3, -2e-3, 0.01, 0.02, -0.01, 0.004};
  const LensRays rays = load_lens_rays(model_file("LENSMODEL_OPENCV8", p), kColumns, kRows);
  const double worst = round_trip_px(rays, [&](const Vector3<double>& v) {
    const double x = v.x() / v.z(), y = v.y() / v.z(), r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
    const double radial = (1 + p[4] * r2 + p[5] * r4 + p[8] * r6) / (1 + p[9] * r2 + p[10] * r4 + p[11] * r6);
    const double u = x * radial + 2 * p[6] * x * y + p[7] * (r2 + 2 * x * x);
    const double w = y * radial + p[6] * (r2 + 2 * y * y) + 2 * p[7] * x * y;
    return PixelPosition{p[0] * u + p[2], p[1] * w + p[3]};
  });
  EXPECT_LE(worst, 1e-6);  // mrcal stops its search there
}

TEST(Lens, StereographicInvertsItsForwardModel) {
  const double f = 25, cx = 28.9, cy = 20.4;
  const LensRays rays = load_lens_rays(model_file("LENSMODEL_STEREOGRAPHIC", {f, f, cx, cy}), kColumns, kRows);
  const double worst = round_trip_px(rays, [&](const Vector3<double>& v) {
    const double scale = 2 * f / (v.norm() + v.z());  // 2 tan(theta/2) along the azimuth
    return PixelPosition{scale * v.x() + cx, scale * v.y() + cy};
  });
  EXPECT_LE(worst, 1e-12);
}

// The sphere's area under the frame, by the pixels' solid angles and by the model's own Jacobian.
TEST(Lens, SolidAnglesOfStereographicFollowItsScale) {
  const double f = 25, cx = 28.9, cy = 20.4;
  const LensRays rays = load_lens_rays(model_file("LENSMODEL_STEREOGRAPHIC", {f, f, cx, cy}), kColumns, kRows);
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const double z = rays.direction(r, c).z();
      const double expected = std::pow((1 + z) / (2 * f), 2);  // conformal: the scale is 2f/(1 + cos theta) per rad
      EXPECT_LE(std::abs(rays.solid_angle_sr(r, c) / expected - 1), 2e-3);  // (1/f)² of differences over a pixel
    }
  }
}

std::string refusal(const std::filesystem::path& path, int columns) {
  try {
    load_lens_rays(path, columns, kRows);
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

// mrcal's own reader ran past the end of the string that is not closed here (found by fuzzing).
TEST(Lens, RefusesDamagedFilesBeforeMrcalSeesThem) {
  const std::string model = "'lensmodel': 'LENSMODEL_PINHOLE'", numbers = "'intrinsics': [ 1, 1, 0, 0 ]",
                    size = "'imagersize': [ 60, 40 ]";
  const auto dictionary = [](const std::string& a, const std::string& b, const std::string& c) {
    return "{ # comment\n" + a + ",\n" + b + ",\n" + c + ",\n}\n";
  };
  const auto said = [&](const std::string& text) {
    const std::filesystem::path path = testing::TempDir() + "lens_test_damaged.cameramodel";
    write_text_file(path, text, Overwrite::kForce);
    return refusal(path, kColumns);
  };
  EXPECT_EQ(said(dictionary(model, numbers, size)), "accepted");
  EXPECT_EQ(said(dictionary(model, numbers, size + ",\n'optimization_inputs': b'ab\\'c', 'x': [(1, 'y'), None]")),
            "accepted");
  struct Case {
    std::string text, reason;
  };
  const std::vector<Case> cases{
      {dictionary("'lensmodel':  'LENSMODEL_CAHVORE_lineintrinsics are fx, 0.02 ]", numbers, size),
       ":2: has a string without end"},
      {"{ 'lensmodel': 'LENSMODEL_PIN", "string without end"},
      {dictionary(model, numbers, model), "states a key twice"},
      {dictionary("'lensmodel': 'LENSMODEL_OPENCV99'", numbers, size), "is no lens model"},
      {dictionary("'lensmodel': 'LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=99999_Ny=99999_fov_x_deg=60'", numbers,
                  size),
       "is no lens model"},
      {dictionary("'lensmodel': 'LENSMODEL_OPENCV4'", numbers, size),
       "wrong number of values for LENSMODEL_OPENCV4, got 4, expected 8"},
      {dictionary(model, "'intrinsics': [ 1, nan, 0, 0 ]", size), ":3: has something that is not a number"},
      {dictionary(model, "'intrinsics': [ 0, 1, 0, 0 ]", size), "focal length"},
      {dictionary(model, numbers, "'imagersize': [ 60.5, 40 ]"), ":4: has an imagersize"},
      {dictionary(model, numbers, "'a': " + std::string(100000, '[')), "nested too deep"},
      {dictionary(model, numbers, size) + "x", "goes on after its end"},
      {dictionary(model, numbers, "'b': 1"), "lacks imagersize"},
      {"", "expected '{'"},
  };
  for (const Case& c : cases) EXPECT_NE(said(c.text).find(c.reason), std::string::npos) << said(c.text);
}

TEST(Lens, RefusesWhatItCannotUse) {
  EXPECT_NE(refusal("/nowhere/a.cameramodel", kColumns).find("does not exist"), std::string::npos);
  const std::filesystem::path junk = testing::TempDir() + "lens_test_junk.cameramodel";
  write_text_file(junk, "not a model\n", Overwrite::kForce);
  EXPECT_NE(refusal(junk, kColumns).find("no camera model"), std::string::npos);
  EXPECT_NE(refusal(model_file("LENSMODEL_PINHOLE", {1, 1, 0, 0}), 61).find("60 x 40"), std::string::npos);
}

}  // namespace
}  // namespace scatmap
