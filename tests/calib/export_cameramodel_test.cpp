// A bare CCD written as a pinhole camera model, read back by mrcal itself, maps every pixel as the bare CCD does. Does
// not prove what other programs do with the file.
#include "calib/export_cameramodel.h"

#include <gtest/gtest.h>

#include "scatmap/angles/lens.h"
#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"
#include "scatmap/base/units.h"

namespace scatmap::calib {
namespace {

Instrument bench(bool flip_columns, bool flip_rows) {
  Instrument in = parse_instrument(
      "[detector]\ncolumns = 64\nrows = 48\npitch_um = [226.5, 230.1]\ndistance_mm = 324.3\noffset_mm = [2.1, -1.7]\n"
      "rotation_deg = [1.35, -2.42, 3.28]\n[arm]\nzero_deg = 0.6\naxis_offset_mm = [0.12, -0.9]\naxis_tilt_deg = [0.5, "
      "-0.4]\n"
      "[beam]\nelevation_deg = 0.3\noffset_mm = [0.8, -0.6]\n[sample]\ntilt_deg = 0.7\nheight_mm = 0.11\n",
      "bench");
  in.flip_columns = flip_columns;
  in.flip_rows = flip_rows;
  return in;
}

TEST(ExportCameramodel, MrcalReadsItAndSeesWhatTheBareDetectorSees) {
  for (const bool flips : {false, true}) {
    for (const double arm_deg : {20.0, 75.0, -60.0}) {
      const Instrument in = bench(flips, flips);
      const SampleView view = sample_view(in, {0.5 * arm_deg * kRadPerDeg, arm_deg * kRadPerDeg});
      const std::filesystem::path file = testing::TempDir() + "export_test.cameramodel";
      write_text_file(file, to_cameramodel(pinhole_at_spot(view, in.columns, in.rows), "made by a test\nsecond line"),
                      Overwrite::kForce);
      const AngleMap bare = angle_map(view, in.rows, in.columns),
                     lens = angle_map(view, load_lens_rays(file, in.columns, in.rows));
      for (std::size_t i = 0; i < bare.mask.size(); ++i) {
        ASSERT_EQ(bare.mask[i], lens.mask[i]);
        if (bare.mask[i] != 0) continue;
        const auto a = direction_from_angles<double>(bare.theta_s_rad[i], bare.phi_s_rad[i]);
        const auto b = direction_from_angles<double>(lens.theta_s_rad[i], lens.phi_s_rad[i]);
        EXPECT_LE(angle_between<double>(a, b), 1e-12);
        EXPECT_LE(std::abs(lens.solid_angle_sr[i] / bare.solid_angle_sr[i] - 1), 1e-6);
      }
    }
  }
}

// The pose in the file turns sample directions into the camera's: the specular direction lands on its pixel.
TEST(ExportCameramodel, PoseTurnsSampleAxesIntoTheCameras) {
  const Instrument in = bench(false, false);
  const SampleView view = sample_view(in, {10 * kRadPerDeg, 20 * kRadPerDeg});
  const PinholeCamera camera = pinhole_at_spot(view, in.columns, in.rows);
  const Eigen::Vector3d v = camera.camera_from_sample * view.pixel(12.25, 33.5);
  EXPECT_NEAR(camera.focal_column_px * v.x() / v.z() + camera.centre_column_px, 12.25, 1e-9);
  EXPECT_NEAR(camera.focal_row_px * v.y() / v.z() + camera.centre_row_px, 33.5, 1e-9);
  EXPECT_NEAR(camera.camera_from_sample.determinant(), 1, 1e-14);
}

TEST(ExportCameramodel, MirroredImageIsRefused) {
  for (const bool flip : {false, true}) {
    const Instrument in = bench(flip, !flip);
    EXPECT_THROW(pinhole_at_spot(sample_view(in, {0.1, 0.2}), in.columns, in.rows), Error);
  }
}

}  // namespace
}  // namespace scatmap::calib
