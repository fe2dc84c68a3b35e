// Newton's inverse of OpenCV's distortion against its forward model in long double, against mrcal_unproject, and where
// the lens has no answer. Does not prove that a real lens follows the model.
#include "scatmap/angles/opencv_lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

extern "C" {
#include <mrcal/mrcal.h>
}

#include "scatmap/angles/angle_map.h"
#include "scatmap/base/direction.h"

namespace scatmap {
namespace {

constexpr int kColumns = 1027, kRows = 768;

OpencvLens strong() {
  return {1100, 1090, 510.3, 380.7, {-0.25, 0.06, 1e-3, -2e-3, 0.01, 0.02, -0.01, 0.004, 1e-3, -2e-4, 5e-4, 1e-4}};
}

struct Projected {
  long double column, row;
};

Projected project(const OpencvLens& l, long double x, long double y) {
  const auto& k = l.k;
  const long double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const long double radial = (1 + k[0] * r2 + k[1] * r4 + k[4] * r6) / (1 + k[5] * r2 + k[6] * r4 + k[7] * r6);
  return {l.fx * (x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x) + k[8] * r2 + k[9] * r4) + l.cx,
          l.fy * (y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y + k[10] * r2 + k[11] * r4) + l.cy};
}

struct Rays {
  explicit Rays(int columns) : x(static_cast<std::size_t>(columns)), y(x.size()), omega(x.size()) {}
  std::vector<double> x, y, omega;
  LensRow row() { return {x, y, omega}; }
};

TEST(OpencvLens, RaysProjectOntoTheirPixels) {
  const OpencvLens lens = strong();
  Rays rays(kColumns);
  long double worst = 0;
  for (int r = 0; r < kRows; r += 3) {
    unproject_row(lens, r, {0, kColumns}, rays.row());
    for (int c = 0; c < kColumns; ++c) {
      const auto i = static_cast<std::size_t>(c);
      const Projected p = project(lens, rays.x[i], rays.y[i]);
      const long double error = std::hypot(p.column - c, p.row - r);
      if (!(error <= worst)) worst = error;
    }
  }
  EXPECT_LE(worst, kLensMaxError_px);
}

TEST(OpencvLens, SolidAnglesAreTheRaysDerivatives) {
  const OpencvLens lens = strong();
  Rays above(kColumns), at(kColumns), below(kColumns);
  unproject_row(lens, 99, {0, kColumns}, above.row());
  unproject_row(lens, 100, {0, kColumns}, at.row());
  unproject_row(lens, 101, {0, kColumns}, below.row());
  const auto ray = [](const Rays& rays, int c) {
    const auto i = static_cast<std::size_t>(c);
    return Vector3<double>(rays.x[i], rays.y[i], 1).normalized();
  };
  for (int c = 1; c < kColumns - 1; ++c) {
    const double area = 0.25 * (ray(at, c + 1) - ray(at, c - 1)).cross(ray(below, c) - ray(above, c)).dot(ray(at, c));
    EXPECT_LE(std::abs(at.omega[static_cast<std::size_t>(c)] / area - 1), 1e-5);  // differences over two pixels: (1/f)²
  }
}

TEST(OpencvLens, MrcalUnproject) {
  const OpencvLens lens = strong();
  std::vector<double> intrinsics{lens.fx, lens.fy, lens.cx, lens.cy};
  intrinsics.insert(intrinsics.end(), lens.k.begin(), lens.k.end());
  for (const auto& [type, name, count] : {std::tuple{MRCAL_LENSMODEL_OPENCV4, "LENSMODEL_OPENCV4", 8},
                                          {MRCAL_LENSMODEL_OPENCV5, "LENSMODEL_OPENCV5", 9},
                                          {MRCAL_LENSMODEL_OPENCV8, "LENSMODEL_OPENCV8", 12},
                                          {MRCAL_LENSMODEL_OPENCV12, "LENSMODEL_OPENCV12", 16}}) {
    const auto ours = opencv_lens(name, {intrinsics.data(), static_cast<std::size_t>(count)});
    ASSERT_TRUE(ours.has_value());
    mrcal_lensmodel_t model{};
    model.type = type;
    for (const int row : {0, 300, kRows - 1}) {
      Rays rays(kColumns);
      unproject_row(*ours, row, {0, kColumns}, rays.row());
      for (int c = 0; c < kColumns; c += 19) {
        mrcal_point2_t pixel{};
        mrcal_point3_t theirs{};
        pixel.x = c;
        pixel.y = row;
        ASSERT_TRUE(mrcal_unproject(&theirs, &pixel, 1, &model, intrinsics.data()));
        const auto i = static_cast<std::size_t>(c);
        const double angle = angle_between<double>({rays.x[i], rays.y[i], 1}, {theirs.x, theirs.y, theirs.z});
        EXPECT_LE(angle * lens.fx, 1e-6) << name << " " << c;  // mrcal stops its search at 1e-8 px
      }
    }
  }
}

// Barrel distortion that folds back: x' = x − x³ grows up to x = 0.577, where x' = 0.385, and no farther pixel is seen.
TEST(OpencvLens, BeyondTheFoldThereIsNoRay) {
  const OpencvLens lens{1000, 1000, 500, 0, {-1}};
  Rays rays(1001);
  unproject_row(lens, 0, {0, 1001}, rays.row());
  const double edge = 1000 * 2 / (3 * std::sqrt(3.0));
  int none = 0;
  for (int c = 0; c < 1001; ++c) {
    const double away = std::abs(c - 500.0), x = rays.x[static_cast<std::size_t>(c)];
    EXPECT_EQ(std::isnan(x), away > edge) << c;
    none += std::isnan(x);
    if (away < edge) {
      EXPECT_LE(std::abs(x), 1 / std::sqrt(3.0)) << c;
    }
  }
  EXPECT_EQ(none, 2 * (500 - 384));
}

// x' = x − x³/2 + x⁵/10 folds back at x = 1, where x' = 0.6, and grows again from √2 on, without end: what is met there
// is no ray of the lens.
TEST(OpencvLens, BeyondTheFoldASecondBranchIsNoRay) {
  const OpencvLens lens{1000, 1000, 1000, 0, {-0.5, 0.1}};
  Rays rays(2001);
  unproject_row(lens, 0, {0, 2001}, rays.row());
  for (int c = 0; c < 2001; ++c) {
    const double away = std::abs(c - 1000.0), x = rays.x[static_cast<std::size_t>(c)];
    if (away == 600) continue;  // on the fold
    EXPECT_EQ(std::isnan(x), away > 600) << c;
    if (away < 600) {
      EXPECT_LE(std::abs(x), 1) << c;
    }
  }
}

// The denominator 1 − 2 r² + r⁶/4 is 0 at r = 0.719 and positive again beyond r = 1.59.
TEST(OpencvLens, BehindAPoleOfTheDenominatorIsNoRay) {
  const OpencvLens lens{100, 100, 1000, 0, {0, 0, 0, 0, 0, -2, 0, 0.25}};
  Rays rays(2001);
  unproject_row(lens, 0, {0, 2001}, rays.row());
  for (int c = 0; c < 2001; ++c) {
    const double x = rays.x[static_cast<std::size_t>(c)];
    EXPECT_LE(std::abs(x), 0.74) << c;  // NaN fails: up to the pole every pixel has its ray
    EXPECT_LE(std::abs(static_cast<double>(project(lens, x, 0).column) - c), 1e-11) << c;
  }
}

TEST(OpencvLens, AnglesAreThoseOfTheRays) {
  const OpencvLens lens = strong();
  Matrix3<double> turn = rotation_y<double>(1.2) * rotation_x<double>(0.4);
  std::vector<double> theta(kColumns), phi(kColumns), omega(kColumns);
  std::vector<Mask> mask(kColumns);
  AngleRow<double> out;
  out.theta_s_rad = theta;
  out.phi_s_rad = phi;
  out.solid_angle_sr = omega;
  out.mask = mask;
  Rays rays(kColumns);
  int below = 0;
  for (const int r : {0, 400, 767}) {
    lens_angle_row(lens, turn, r, {0, kColumns}, out);
    unproject_row(lens, r, {0, kColumns}, rays.row());
    for (std::size_t i = 0; i < theta.size(); ++i) {
      const Vector3<double> ray = turn * Vector3<double>(rays.x[i], rays.y[i], 1);
      ASSERT_EQ(mask[i], ray.z() > 0 ? 0 : kBelowHorizon);
      ASSERT_EQ(std::isnan(theta[i]), mask[i] != 0);
      below += mask[i] != 0;
      if (mask[i] != 0) continue;
      EXPECT_LE(std::abs(theta[i] - polar_angle(ray)), kVectorMaxError_rad + 1e-15);
      EXPECT_LE(std::abs(phi[i] - azimuth_from_minus_x(ray)), 2e-15);
      EXPECT_EQ(omega[i], rays.omega[i]);
    }
  }
  EXPECT_GT(below, 100);
  EXPECT_LT(below, 2000);
}

}  // namespace
}  // namespace scatmap
