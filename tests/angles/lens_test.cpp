// Rays of mrcal's lens models, read through the optional module, against forward projections written here from the
// models' published definitions; the pinhole against its closed form. Does not prove the bare CCD's equality with a
// pinhole (tests/calib/export_cameramodel_test.cpp), nor the verbs with a lens (tests/cli/lens_test.cpp).
#include "scatmap/angles/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

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

TEST(Lens, Opencv4InvertsItsForwardModel) {
  const std::vector<double> p{90, 92, 29.3, 20.1, -0.11, 0.04, 1e-3, -2e-3};
  const LensRays rays = load_lens_rays(model_file("LENSMODEL_OPENCV4", p), kColumns, kRows);
  const double worst = round_trip_px(rays, [&](const Vector3<double>& v) {
    const double x = v.x() / v.z(), y = v.y() / v.z(), r2 = x * x + y * y;
    const double radial = 1 + p[4] * r2 + p[5] * r2 * r2;
    const double u = x * radial + 2 * p[6] * x * y + p[7] * (r2 + 2 * x * x);
    const double w = y * radial + p[6] * (r2 + 2 * y * y) + 2 * p[7] * x * y;
    return PixelPosition{p[0] * u + p[2], p[1] * w + p[3]};
  });
  EXPECT_LE(worst, 1e-6);
}

// Axis of symmetry o by azimuth and elevation; points move towards or away from it by a polynomial of tan² of the angle
// to it (Yakimovsky and Cunningham's CAHV with Gennery's radial terms).
TEST(Lens, CahvorInvertsItsForwardModel) {
  const std::vector<double> p{90, 92, 29.3, 20.1, 0.01, -0.02, 0.002, -0.03, 0.01};
  const LensRays rays = load_lens_rays(model_file("LENSMODEL_CAHVOR", p), kColumns, kRows);
  EXPECT_EQ(rays.model, "LENSMODEL_CAHVOR");
  const Vector3<double> o(std::sin(p[4]) * std::cos(p[5]), std::sin(p[5]), std::cos(p[4]) * std::cos(p[5]));
  const double worst = round_trip_px(rays, [&](const Vector3<double>& v) {
    const double along = v.dot(o), tan2 = v.squaredNorm() / (along * along) - 1;
    const double mu = p[6] + tan2 * (p[7] + tan2 * p[8]);
    const Vector3<double> moved = (1 + mu) * v - mu * along * o;
    return PixelPosition{p[0] * moved.x() / moved.z() + p[2], p[1] * moved.y() / moved.z() + p[3]};
  });
  EXPECT_LE(worst, 1e-6);
}

double spline_weight(int k, double t) {  // cubic B-spline, segment k of four
  switch (k) {
    case 0:
      return std::pow(1 - t, 3) / 6;
    case 1:
      return (3 * t * t * t - 6 * t * t + 4) / 6;
    case 2:
      return (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6;
    default:
      return t * t * t / 6;
  }
}

// A stereographic projection u plus a correction by cubic B-splines over a grid of control points in u, spaced so that
// the field of view leaves one interval at each end.
TEST(Lens, SplinedStereographicInvertsItsForwardModel) {
  constexpr int kNx = 15, kNy = 11;
  const double f = 25, cx = 28.9, cy = 20.4, fov_deg = 140;
  std::vector<double> p{f, f, cx, cy};
  for (int i = 0; i < 2 * kNx * kNy; ++i) p.push_back(0.03 * std::sin(1.7 * i + 0.3));
  const LensRays rays = load_lens_rays(
      model_file("LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=15_Ny=11_fov_x_deg=140", p), kColumns, kRows);
  EXPECT_EQ(rays.model, "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=15_Ny=11_fov_x_deg=140");
  const double edge = 2 * std::tan(fov_deg / 4 * std::numbers::pi / 180), per_u = (kNx - 3) / (2 * edge);
  const double worst = round_trip_px(rays, [&](const Vector3<double>& v) {
    const double scale = 2 / (v.norm() + v.z()), u = scale * v.x(), w = scale * v.y();
    const double x = u * per_u + 0.5 * (kNx - 1), y = w * per_u + 0.5 * (kNy - 1);
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    double du = 0, dw = 0;
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        const double weight = spline_weight(a, x - i) * spline_weight(b, y - j);
        const auto at = static_cast<std::size_t>(4 + 2 * ((j - 1 + b) * kNx + i - 1 + a));
        du += weight * p.at(at);
        dw += weight * p.at(at + 1);
      }
    }
    return PixelPosition{f * (u + du) + cx, f * (w + dw) + cy};
  });
  EXPECT_LE(worst, 1e-6);
}

// Between pixels the directions of the angle map are the lens's own, to second order in a pixel.
TEST(Lens, InterpolatedDirectionsAreThoseBetweenThePixels) {
  const double f = 250, cx = 28.9, cy = 20.4;
  const Instrument in = parse_instrument(
      "[detector]\ncolumns = 60\nrows = 40\npitch_um = [10, 10]\ndistance_mm = 300\nlens_cameramodel = \"" +
          model_file("LENSMODEL_STEREOGRAPHIC", {f, f, cx, cy}).string() + "\"\n",
      "lens");
  const Pose pose{0.2, 0.5};
  const AngleMap map = angle_map(in, pose);
  const SampleView view = sample_view(in, pose);
  for (const auto& [c, r] : {std::pair{0.0, 0.0}, {12.25, 30.5}, {58.75, 38.5}, {59.0, 39.0}}) {
    const double x = (c - cx) / f, y = (r - cy) / f, q = (x * x + y * y) / 4;
    const Vector3<double> expected =
        x * view.column_step.normalized() + y * view.row_step.normalized() + (1 - q) * view.detector_normal;
    EXPECT_LE(angle_between<double>(interpolated_direction(map, {c, r}), expected), 1 / (8 * f * f)) << c << " " << r;
  }
  EXPECT_TRUE(std::isnan(interpolated_direction(map, {59.01, 0}).x()));
  EXPECT_TRUE(std::isnan(interpolated_direction(map, {3, -0.01}).x()));
}

TEST(Lens, InstrumentKeepsItsLensAndIsBesideItsFile) {
  const std::filesystem::path model = model_file("LENSMODEL_PINHOLE", {800, 800, 30, 20});
  const std::string text =
      "[detector]\ncolumns = 60\nrows = 40\npitch_um = [10, 10]\ndistance_mm = 300\nlens_cameramodel = "
      "\"lens_test.cameramodel\"\n";
  const std::filesystem::path file = testing::TempDir() + "lens_test_instrument.toml";
  write_text_file(file, text, Overwrite::kForce);
  const Instrument in = read_instrument(file);
  ASSERT_TRUE(in.lens_cameramodel.has_value());
  EXPECT_TRUE(in.lens_cameramodel->is_absolute());
  EXPECT_EQ(std::filesystem::canonical(*in.lens_cameramodel), std::filesystem::canonical(model));
  const Instrument again = parse_instrument(to_toml(in), "/nowhere/text.toml");
  EXPECT_EQ(again.lens_cameramodel, in.lens_cameramodel);
  const std::filesystem::path odd = testing::TempDir() + "lens \"quoted\" \\ \xc3\xa9\t.cameramodel";
  std::filesystem::copy_file(model, odd, std::filesystem::copy_options::overwrite_existing);
  Instrument renamed = in;
  renamed.lens_cameramodel = odd;
  EXPECT_EQ(parse_instrument(to_toml(renamed), "text").lens_cameramodel, odd);
  std::filesystem::remove(odd);
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
